/* SPDX-License-Identifier: MIT
 *
 * Quantities over wavelength: tables, reflectances, the spectra of sources.
 */
#include <string.h>

#include "io/scene/scene_reader.h"

static void read_column(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                        const char *key, const struct rmap_range *range, size_t *n_ret,
                        double **column_ret)
{
    const struct rmap_yaml_node *list = rmap_yaml_get(node, key);
    char what[80];
    (void)snprintf(what, sizeof what, "'%s'", key);
    *n_ret = 0;
    if (!rmap_reader_check_list(reader, list, what))
        return;
    double *column = rmap_reader_alloc(reader, list->n_item, sizeof *column);
    if (!column)
        return;
    bool good = true;
    for (size_t i = 0; i < list->n_item; i++)
        good &= rmap_reader_scalar(reader, list->item[i].value, what, range, &column[i]);
    if (!list->n_item)
        rmap_reader_error(reader, list, "%s must not be empty", what);
    if (good && list->n_item) {
        *n_ret = list->n_item;
        *column_ret = column;
    }
}

static bool is_increasing(struct rmap_reader *reader, const struct rmap_yaml_node *list,
                          const double *value, size_t n)
{
    for (size_t i = 1; i < n; i++) {
        if (value[i] > value[i - 1])
            continue;
        rmap_reader_error(reader, list->item[i].value,
                          "wavelengths must increase, but %g follows %g", value[i], value[i - 1]);
        return false;
    }
    return true;
}

void rmap_reader_table(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       const char *keys, size_t n_required, const struct rmap_range *range,
                       size_t *n_ret, double **column)
{
    struct rmap_words key;
    bool good = true;
    *n_ret = 0;
    rmap_words_split(keys, &key);
    for (size_t k = 0; k < key.n; k++)
        column[k] = NULL;
    if (!rmap_reader_check_keys(reader, node, "a table", key.word, key.n))
        return;
    size_t n_row = 0;
    for (size_t k = 0; k < key.n; k++) {
        const struct rmap_yaml_node *list = rmap_yaml_get(node, key.word[k]);
        size_t n = 0;
        if (!list && k >= n_required)
            continue;
        if (!list) {
            rmap_reader_error(reader, node, "'%s' is missing: add it", key.word[k]);
            good = false;
            continue;
        }
        read_column(reader, node, key.word[k], k ? range : &rmap_range_positive, &n, &column[k]);
        good &= n > 0;
        if (k == 0)
            n_row = n;
        else if (n && n_row && n != n_row) {
            rmap_reader_error(reader, list, "'%s' has %zu entries, 'wavelength' has %zu",
                              key.word[k], n, n_row);
            good = false;
        }
    }
    good = good && is_increasing(reader, rmap_yaml_get(node, key.word[0]), column[0], n_row);
    if (good)
        *n_ret = n_row;
}

static bool read_rgb(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                     const struct rmap_range *range, struct rmap_spectrum *spectrum)
{
    size_t n = 0;
    spectrum->kind = RMAP_SPECTRUM_RGB;
    return rmap_reader_numbers(reader, node, "rgb", RMAP_REQUIRED, range, 3, 3, spectrum->rgb, &n);
}

/* {wavelength: [...], value: [...]} */
static void read_table(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       const struct rmap_range *range, struct rmap_spectrum *spectrum, bool *good)
{
    double *column[2];
    rmap_reader_table(reader, node, "wavelength value", 2, range, &spectrum->table.n, column);
    *good = spectrum->table.n > 0;
    if (*good) {
        spectrum->kind = RMAP_SPECTRUM_TABLE;
        spectrum->table.wavelength_nm = column[0];
        spectrum->table.value = column[1];
    }
}

void rmap_reader_quantity(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                          const char *key, enum rmap_need need, const struct rmap_range *range,
                          double *value)
{
    struct rmap_spectrum spectrum = {.kind = RMAP_SPECTRUM_EQUAL};
    const struct rmap_yaml_node *node = rmap_yaml_get(map, key);
    bool good = true;
    if (!node || node->kind == RMAP_YAML_SCALAR) {
        good = rmap_reader_number(reader, map, key, need, range, &spectrum.value) && node;
    } else if (rmap_yaml_get(node, "rgb")) {
        (void)rmap_reader_check_map(reader, node, "an rgb value", "rgb");
        good = read_rgb(reader, node, range, &spectrum);
    } else if (rmap_yaml_get(node, "wavelength") || rmap_yaml_get(node, "value")) {
        read_table(reader, node, range, &spectrum, &good);
    } else {
        char what[120];
        (void)snprintf(what, sizeof what, "'%s' (a number, {wavelength, value} or {rgb})", key);
        if (rmap_reader_check_map(reader, node, what, "rgb wavelength value") && !node->n_item)
            rmap_reader_error(reader, node, "%s is empty", what);
        good = false;
    }
    if (good)
        rmap_spectrum_sample(&spectrum, &reader->scene->channels, value);
}

static void read_lines(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       struct rmap_spectrum *spectrum)
{
    if (node->kind != RMAP_YAML_MAP || !node->n_item) {
        rmap_reader_error(reader, node, "'lines' must be a mapping {wavelength: power, ...}");
        return;
    }
    double *nm = rmap_reader_alloc(reader, node->n_item, sizeof *nm);
    double *power = rmap_reader_alloc(reader, node->n_item, sizeof *power);
    if (!nm || !power)
        return;
    size_t n = 0;
    for (size_t i = 0; i < node->n_item; i++) {
        const struct rmap_yaml_item *item = &node->item[i];
        const struct rmap_yaml_node place = {.line = item->line, .column = item->column};
        if (!rmap_reader_parse_number(item->key, strlen(item->key), &nm[n]) || !(nm[n] > 0)) {
            rmap_reader_error(reader, &place, "a wavelength in nm must stand here, not '%.40s'",
                              item->key);
            continue;
        }
        if (!rmap_reader_scalar(reader, item->value, "the power of a line", &rmap_range_nonnegative,
                                &power[n]))
            continue;
        if (reader->scene->channels.mode == RMAP_COLOUR_SPECTRAL &&
            rmap_reader_channel(reader, &place, nm[n]) < 0)
            continue;
        n++;
    }
    if (n) {
        spectrum->kind = RMAP_SPECTRUM_LINES;
        spectrum->table = (struct rmap_table1){n, nm, power};
    }
}

void rmap_reader_source_spectrum(struct rmap_reader *reader, const struct rmap_yaml_node *source,
                                 struct rmap_spectrum *spectrum)
{
    const struct rmap_yaml_node *node = rmap_yaml_get(source, "spectrum");
    bool good = true;
    *spectrum = (struct rmap_spectrum){.kind = RMAP_SPECTRUM_EQUAL, .value = 1};
    if (!node)
        return;
    if (node->kind == RMAP_YAML_SCALAR) {
        int choice = 0;
        (void)rmap_reader_choice(reader, source, "spectrum", RMAP_OPTIONAL, "equal D65", &choice);
        spectrum->kind = choice ? RMAP_SPECTRUM_D65 : RMAP_SPECTRUM_EQUAL;
        return;
    }
    if (!rmap_reader_check_map(reader, node, "a spectrum",
                               "lines table blackbody rgb wavelength value"))
        return;
    const struct rmap_yaml_node *lines = rmap_yaml_get(node, "lines");
    const struct rmap_yaml_node *table = rmap_yaml_get(node, "table");
    bool plain = rmap_yaml_get(node, "wavelength") || rmap_yaml_get(node, "value");
    bool blackbody = rmap_yaml_get(node, "blackbody") != NULL;
    bool rgb = rmap_yaml_get(node, "rgb") != NULL;
    if (!!lines + !!table + plain + blackbody + rgb != 1)
        rmap_reader_error(reader, node,
                          "a spectrum is one of: D65, equal, {lines: {nm: power}}, {table: "
                          "{wavelength, value}}, {blackbody: kelvin}, {rgb: [r, g, b]}");
    else if (lines)
        read_lines(reader, lines, spectrum);
    else if (table || plain)
        read_table(reader, table ? table : node, &rmap_range_nonnegative, spectrum, &good);
    else if (rgb)
        (void)read_rgb(reader, node, &rmap_range_nonnegative, spectrum);
    else if (rmap_reader_number(reader, node, "blackbody", RMAP_REQUIRED, &rmap_range_positive,
                                &spectrum->temperature_k))
        spectrum->kind = RMAP_SPECTRUM_BLACKBODY;
}
