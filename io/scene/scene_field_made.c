/* SPDX-License-Identifier: MIT
 *
 * Gradient media of noise, of formulas, and of other fields: sums, indices over a scalar.
 */
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "gradient/field_formula.h"
#include "gradient/field_made.h"
#include "gradient/field_noise.h"
#include "io/scene/scene_field.h"

#define REQUIRED ((double)NAN)

/* ---- noise ---- */

static void read_noise(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       const struct rmap_field_place *place, struct rmap_field **field_ret)
{
    static const struct rmap_field_parameter parameter[] = {{"mean", REQUIRED},
                                                            {"amplitude", REQUIRED}};
    struct rmap_noise noise[RMAP_CHANNEL_MAX] = {
        {.length = 1, .persistence = 0.5, .lacunarity = 2}};
    double value[2 * RMAP_CHANNEL_MAX] = {0};
    uint64_t octaves = 1;
    bool good = true;
    (void)place;
    rmap_reader_parameters(reader, node, parameter, 2, value, &good);
    good &= rmap_reader_number(reader, node, "length", RMAP_REQUIRED, &rmap_range_positive_length,
                               &noise->length);
    good &= rmap_reader_number(reader, node, "persistence", RMAP_OPTIONAL, &rmap_range_nonnegative,
                               &noise->persistence);
    good &= rmap_reader_number(reader, node, "lacunarity", RMAP_OPTIONAL, &rmap_range_positive,
                               &noise->lacunarity);
    good &= rmap_reader_whole(reader, node, "octaves", 1, RMAP_NOISE_OCTAVE_MAX, &octaves);
    good &= rmap_reader_whole(reader, node, "seed", 0, (uint64_t)1 << 53, &noise->seed);
    noise->n_octave = (int)octaves;
    const int n_channel = rmap_reader_distinct(reader, value, 2);
    for (int c = n_channel - 1; c >= 0; c--) {
        noise[c] = noise[0];
        noise[c].mean = value[2 * c];
        noise[c].amplitude = value[2 * c + 1];
    }
    if (good)
        rmap_reader_made(reader, node,
                         rmap_field_noise(field_ret, n_channel, noise, &reader->failure));
}

/* ---- formulas ---- */

/* {name: value, ...} */
static void read_constants(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           struct rmap_formula *formula, bool *good)
{
    const struct rmap_yaml_node *map = rmap_yaml_get(node, "constants");
    if (!map)
        return;
    if (map->kind != RMAP_YAML_MAP) {
        rmap_reader_error(reader, map, "'constants' must be a mapping {name: value, ...}");
        *good = false;
        return;
    }
    const char **name = rmap_reader_alloc(reader, map->n_item, sizeof *name);
    double *value = rmap_reader_alloc(reader, map->n_item, sizeof *value);
    if (!name || !value)
        return;
    for (size_t i = 0; i < map->n_item; i++) {
        name[i] = map->item[i].key;
        *good &= rmap_reader_scalar(reader, map->item[i].value, "a constant", &rmap_range_any,
                                    &value[i]);
    }
    formula->n_constant = map->n_item;
    formula->constant = name;
    formula->constant_value = value;
}

static void read_slopes(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                        struct rmap_formula *formula, bool *good)
{
    const struct rmap_yaml_node *list = rmap_yaml_get(node, "slope");
    if (!list)
        return;
    bool fine = list->kind == RMAP_YAML_LIST && list->n_item == 3;
    for (size_t i = 0; fine && i < 3; i++) {
        fine = list->item[i].value->kind == RMAP_YAML_SCALAR && list->item[i].value->text[0];
        formula->slope[i] = list->item[i].value->text;
    }
    if (!fine)
        rmap_reader_error(reader, list,
                          "'slope' must be a list of 3 formulas: of the slopes along x, y and z");
    *good &= fine;
}

static void read_formula(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                         const struct rmap_field_place *place, struct rmap_field **field_ret)
{
    struct rmap_formula formula = {.size = place->size};
    bool good = true;
    reader->lenient_field = true;
    formula.text = rmap_reader_text(reader, node, "formula", RMAP_REQUIRED);
    read_constants(reader, node, &formula, &good);
    read_slopes(reader, node, &formula, &good);
    good &= rmap_reader_number(reader, node, "difference", RMAP_OPTIONAL,
                               &rmap_range_positive_length, &formula.difference);
    if (good && formula.text)
        rmap_reader_made(reader, rmap_yaml_get(node, "formula"),
                         rmap_field_formula(field_ret, rmap_reader_distinct_wavelengths(reader),
                                            reader->scene->channels.wavelength_nm, &formula,
                                            &reader->failure));
}

/* ---- parts ---- */

/* A part's name among the bundle's fields; arena. */
static char *part_path(struct rmap_reader *reader, const char *path, size_t number)
{
    size_t nbytes = strlen(path) + 24;
    char *part = rmap_reader_alloc(reader, nbytes, 1);
    if (part)
        (void)snprintf(part, nbytes, "%s/%zu", path, number);
    return part;
}

static void read_part(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                      struct rmap_field_place place, size_t number, struct rmap_field **field_ret)
{
    place.path = part_path(reader, place.path, number);
    place.whole = false;
    if (!place.path)
        return;
    rmap_reader_field(reader, node, &place, field_ret);
}

static void read_sum(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                     const struct rmap_field_place *place, struct rmap_field **field_ret)
{
    enum { N_MAX = 64 };
    struct rmap_field *term[N_MAX] = {NULL};
    double weight[N_MAX];
    const struct rmap_yaml_node *terms = rmap_yaml_get(node, "terms");
    struct rmap_field_place as = *place;
    size_t n = 0;
    bool good = true;
    as.weighted = true;
    if (!terms || terms->kind != RMAP_YAML_LIST || !terms->n_item || terms->n_item > N_MAX) {
        rmap_reader_error(reader, terms ? terms : node,
                          "'terms' must be a list of 1 to %d gradients {type: ..., weight: 1}",
                          N_MAX);
        return;
    }
    for (; n < terms->n_item; n++) {
        const struct rmap_yaml_node *part = terms->item[n].value;
        weight[n] = 1;
        read_part(reader, part, as, n + 1, &term[n]);
        good &= term[n] && rmap_reader_number(reader, part, "weight", RMAP_OPTIONAL,
                                              &rmap_range_any, &weight[n]);
    }
    if (!good)
        goto out;
    enum rmap_status st =
        rmap_field_sum(field_ret, place->scalar ? 0 : 1, (int)n, term, weight, &reader->failure);
    memset(term, 0, sizeof term); /* taken */
    rmap_reader_made(reader, node, st);
out:
    for (size_t i = 0; i < N_MAX; i++)
        rmap_field_destroy(term[i]);
}

/* ---- an index over a scalar ---- */

static const char *const law_word[] = {
    "linear", "gladstone_dale", "air", "seawater_salinity", "seawater_temperature", "table"};

/* {value: [..], n: [..]} */
static void read_law_table(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           struct rmap_index_of *law, int *n_channel, bool *good)
{
    enum { N_MAX = 100000 };
    const struct rmap_yaml_node *table = rmap_yaml_get(node, "table");
    double *at = NULL, *n = NULL;
    size_t n_at = 0, n_point = 0;
    *good = false;
    if (!table)
        rmap_reader_error(reader, node, "'table' is missing: {value: [..], n: [..]}");
    if (!table || !rmap_reader_check_map(reader, table, "a table", "value n"))
        return;
    rmap_reader_channel_list(reader, table, "value", N_MAX, &n_at, &at);
    rmap_reader_channel_list(reader, table, "n", N_MAX, &n_point, &n);
    if (at && n && n_at != n_point)
        rmap_reader_error(reader, rmap_yaml_get(table, "n"), "'n' has %zu entries, 'value' has %zu",
                          n_point, n_at);
    if (!at || !n || n_at != n_point)
        return;
    *n_channel = rmap_reader_distinct(reader, n, n_point);
    for (int c = 0; c < *n_channel; c++) {
        law[c].n_point = (int)n_point;
        law[c].at = at;
        law[c].n = n + (size_t)c * n_point;
    }
    *good = true;
}

/* Two numbers per channel: {n0, slope} or {n0, reference}. */
static void read_law_numbers(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                             struct rmap_index_of *law, int *n_channel, bool *good)
{
    static const struct rmap_field_parameter linear[] = {{"n0", REQUIRED}, {"slope", REQUIRED}};
    static const struct rmap_field_parameter dale[] = {{"n0", REQUIRED}, {"reference", REQUIRED}};
    bool is_linear = law->law == RMAP_INDEX_LINEAR;
    double value[2 * RMAP_CHANNEL_MAX] = {0};
    rmap_reader_parameters(reader, node, is_linear ? linear : dale, 2, value, good);
    *n_channel = *good ? rmap_reader_distinct(reader, value, 2) : 1;
    for (int c = 0; c < *n_channel; c++) {
        law[c].n0 = value[2 * c];
        law[c].slope = is_linear ? value[2 * c + 1] : 0;
        law[c].reference = is_linear ? 0 : value[2 * c + 1];
    }
}

/* What is measured: one number for all channels, at each of their wavelengths. */
static bool read_law_conditions(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                                struct rmap_index_of *law)
{
    const struct rmap_range air = {1, 1e8, "a pressure in Pa, 1 to 1e8"};
    int choice = 0;
    bool good = rmap_reader_choice(reader, node, "unit", RMAP_OPTIONAL, "C K", &choice);
    law->pressure_pa = 101325;
    law->zero_k = choice ? 0 : 273.15;
    law->temperature_c = 20;
    law->salinity = 35;
    good &= rmap_reader_number(reader, node, "pressure", RMAP_OPTIONAL, &air, &law->pressure_pa);
    good &= rmap_reader_number(reader, node, "temperature", RMAP_OPTIONAL, &rmap_range_any,
                               &law->temperature_c);
    good &= rmap_reader_number(reader, node, "salinity", RMAP_OPTIONAL, &rmap_range_nonnegative,
                               &law->salinity);
    return good;
}

/* Keys that belong to another law. */
static bool check_law_keys(struct rmap_reader *reader, const struct rmap_yaml_node *node, int law)
{
    static const struct {
        const char *key;
        unsigned laws; /* bit per law */
    } of[] = {{"n0", 3},        {"slope", 1},       {"reference", 2}, {"pressure", 4},
              {"unit", 4 | 16}, {"temperature", 8}, {"salinity", 16}, {"table", 32}};
    bool good = true;
    for (size_t i = 0; i < RMAP_COUNT(of); i++) {
        const struct rmap_yaml_node *at = rmap_yaml_get(node, of[i].key);
        if (!at || of[i].laws >> law & 1)
            continue;
        rmap_reader_error(reader, at, "'%s' has no part in 'law: %s'", of[i].key, law_word[law]);
        good = false;
    }
    return good;
}

static void read_index_of(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                          const struct rmap_field_place *place, struct rmap_field **field_ret)
{
    struct rmap_field *scalar = NULL;
    struct rmap_index_of law[RMAP_CHANNEL_MAX] = {{0}};
    const struct rmap_yaml_node *of = rmap_yaml_get(node, "field");
    struct rmap_field_place as = *place;
    int choice = 0, n_channel = rmap_reader_distinct_wavelengths(reader);
    as.weighted = false;
    as.scalar = true;
    bool good = rmap_reader_one_of(reader, node, "law", RMAP_REQUIRED, law_word,
                                   RMAP_COUNT(law_word), &choice);
    good = good && check_law_keys(reader, node, choice);
    if (!of)
        rmap_reader_error(reader, node, "'field' is missing: what the index is a function of");
    else
        read_part(reader, of, as, 1, &scalar);
    if (!good || !scalar)
        goto out;
    good = read_law_conditions(reader, node, law);
    for (int c = RMAP_CHANNEL_MAX - 1; c >= 0; c--) {
        law[c] = law[0];
        law[c].law = (enum rmap_index_law)choice;
    }
    if (choice == RMAP_INDEX_LINEAR || choice == RMAP_INDEX_GLADSTONE_DALE)
        read_law_numbers(reader, node, law, &n_channel, &good);
    else if (choice == RMAP_INDEX_TABLE)
        read_law_table(reader, node, law, &n_channel, &good);
    if (!good)
        goto out;
    enum rmap_status st = rmap_field_of_scalar(
        field_ret, scalar, n_channel, reader->scene->channels.wavelength_nm, law, &reader->failure);
    scalar = NULL; /* taken */
    rmap_reader_made(reader, node, st);
out:
    rmap_field_destroy(scalar);
}

/* ---- the table ---- */

static const struct rmap_field_model models[] = {
    {"noise",
     {{0}},
     {"mean", "amplitude", "length", "octaves", "persistence", "lacunarity", "seed"},
     NULL,
     read_noise},
    {"formula", {{0}}, {"formula", "slope", "constants", "difference"}, NULL, read_formula},
    {"sum", {{0}}, {"terms"}, NULL, read_sum},
    {"index_of",
     {{0}},
     {"field", "law", "n0", "slope", "reference", "pressure", "unit", "temperature", "salinity",
      "table"},
     NULL,
     read_index_of},
};

const struct rmap_field_model *rmap_field_model_made(size_t i)
{
    return i < RMAP_COUNT(models) ? &models[i] : NULL;
}
