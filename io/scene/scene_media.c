/* SPDX-License-Identifier: MIT
 *
 * Media: refractive index and absorption on the scene's channels.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "io/scene/scene_glass.h"
#include "io/scene/scene_keys.h"
#include "io/scene/scene_media.h"
#include "io/scene/scene_quantity.h"
#include "io/scene/scene_scintillation.h"
#include "io/scene/scene_turbid.h"

static const struct rmap_range range_index = {1e-3, 1e3, "a refractive index, 0.001 to 1000"};

static struct rmap_medium *new_medium(struct rmap_reader *reader, const char *name, int32_t line)
{
    struct rmap_scene *scene = reader->scene;
    struct rmap_medium *medium =
        RMAP_READER_NEW(reader, scene->medium, scene->n_medium, reader->cap_medium);
    if (!medium)
        return NULL;
    for (int i = 0; i < RMAP_CHANNEL_MAX; i++)
        medium->n[i] = medium->n_group[i] = 1;
    medium->name = rmap_reader_strdup(reader, name);
    rmap_reader_add_name(reader, &reader->media, medium->name, 0, (int32_t)(scene->n_medium - 1),
                         line);
    return medium;
}

static void describe(struct rmap_reader *reader, struct rmap_medium *medium, const char *text)
{
    rmap_free(medium->description);
    medium->description = rmap_reader_strdup(reader, text);
}

/* False after a complaint. */
static bool evaluate(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                     const struct rmap_glass *glass, const char *remedy, struct rmap_medium *medium)
{
    const struct rmap_channels *channels = &reader->scene->channels;
    for (int i = 0; i < channels->n; i++) {
        double n = rmap_glass_index(glass, channels->wavelength_nm[i]);
        if (n >= range_index.from && n <= range_index.to) {
            const double group = rmap_glass_group_index(glass, channels->wavelength_nm[i]);
            medium->n[i] = n;
            medium->n_group[i] = channels->mode == RMAP_COLOUR_RGB || !isfinite(group) ? n : group;
            continue;
        }
        rmap_reader_error(reader, at,
                          "medium '%.60s' has no real refractive index at %g nm: %sleave the "
                          "wavelength out",
                          medium->name, channels->wavelength_nm[i], remedy);
        return false;
    }
    return true;
}

/* Absorption per length unit of k: 4 pi k / lambda (Born & Wolf, 7th ed., 14.1). */
static double absorption_of_k(const struct rmap_scene *scene, double k, double wavelength_nm)
{
    return 4.0 * RMAP_PI * k / (wavelength_nm * 1e-9 / scene->unit_m);
}

/* Of a table of k: linear in between on wavelengths; in RGB, means of the absorption, which
 * `of_rows` has room for. */
static void absorb(const struct rmap_scene *scene, const struct rmap_table1 *k, double *of_rows,
                   struct rmap_medium *medium)
{
    struct rmap_spectrum sampled = {.kind = RMAP_SPECTRUM_TABLE, .table = *k};
    if (scene->channels.mode == RMAP_COLOUR_SPECTRAL) {
        rmap_spectrum_sample(&sampled, &scene->channels, medium->absorption);
        for (int i = 0; i < scene->channels.n; i++)
            medium->absorption[i] =
                absorption_of_k(scene, medium->absorption[i], scene->channels.wavelength_nm[i]);
        return;
    }
    for (size_t i = 0; i < k->n; i++)
        of_rows[i] = absorption_of_k(scene, k->value[i], k->wavelength_nm[i]);
    sampled.table.value = of_rows;
    rmap_spectrum_sample(&sampled, &scene->channels, medium->absorption);
}

static void absorb_as_published(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                                const struct rmap_glass *glass, struct rmap_medium *medium)
{
    const struct rmap_yaml_node *at = rmap_yaml_get(node, "absorption");
    const struct rmap_glass_table *k = &glass->extinction;
    double of_rows[RMAP_GLASS_ROWS_MAX];
    if (k->n == 0) {
        rmap_reader_error(reader, at,
                          "the catalogue has no absorption of %s %s: give 'absorption' as numbers, "
                          "or leave it out",
                          glass->group, glass->name);
        return;
    }
    rmap_reader_warn_outside(reader, at, "medium", medium->name, k->wavelength_nm[0],
                             k->wavelength_nm[k->n - 1],
                             "the ends of its absorption stand for the rest");
    absorb(reader->scene, &(struct rmap_table1){k->n, k->wavelength_nm, k->value}, of_rows, medium);
}

static const char *const formula_name[] = {"table",      "Sellmeier", "Sellmeier",
                                           "polynomial", "general",   "Cauchy"};

static void apply_glass(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                        const struct rmap_glass *glass, struct rmap_medium *medium)
{
    char text[600];
    if (!evaluate(reader, at, glass, "", medium))
        return;
    rmap_reader_warn_outside(reader, at, "medium", medium->name, glass->from_nm, glass->to_nm,
                             glass->formula ? "its formula is extrapolated"
                                            : "its ends stand for the rest");
    (void)snprintf(text, sizeof text, "%s (%s; %s)", glass->name, formula_name[glass->formula],
                   glass->source);
    describe(reader, medium, text);
}

static void read_glass(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       struct rmap_medium *medium)
{
    struct rmap_glass glass;
    if (!rmap_reader_material(reader, node, "glass", &glass))
        return;
    apply_glass(reader, rmap_yaml_get(node, "glass"), &glass, medium);
    if (rmap_reader_is_catalogue(rmap_yaml_get(node, "absorption")))
        absorb_as_published(reader, node, &glass, medium);
}

static void read_sellmeier(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           double unit_um, struct rmap_medium *medium)
{
    const struct rmap_yaml_node *inner = rmap_yaml_get(node, "sellmeier");
    struct rmap_glass glass;
    if (rmap_reader_sellmeier(reader, inner, unit_um, &glass))
        (void)evaluate(reader, inner, &glass, "check B and C (and wavelength_unit), or ", medium);
    describe(reader, medium, "Sellmeier coefficients of the scene");
}

static void read_table(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       double unit_nm, struct rmap_medium *medium)
{
    struct rmap_scene *scene = reader->scene;
    const struct rmap_yaml_node *inner = rmap_yaml_get(node, "table");
    const struct rmap_yaml_node *wavelength = rmap_yaml_get(inner, "wavelength");
    double *column[3];
    size_t n = 0;
    rmap_reader_table(reader, inner, "wavelength n k", 2, &rmap_range_nonnegative, &n, column);
    if (!n)
        return;
    for (size_t i = 0; i < n; i++) {
        const char *text = wavelength->item[i].value->text;
        double bare = 0;
        if (rmap_reader_parse_number(text, strlen(text), &bare))
            column[0][i] *= unit_nm;
        if (column[1][i] < range_index.from || column[1][i] > range_index.to) {
            rmap_reader_error(reader, rmap_yaml_get(inner, "n"), "'n' must be %s, not %g",
                              range_index.text, column[1][i]);
            return;
        }
    }
    const struct rmap_table1 index = {n, column[0], column[1]};
    for (int i = 0; i < scene->channels.n; i++)
        medium->n[i] = medium->n_group[i] =
            rmap_table1_at(&index, scene->channels.wavelength_nm[i]);
    for (int i = 0; i < scene->channels.n && scene->channels.mode == RMAP_COLOUR_SPECTRAL; i++)
        medium->n_group[i] -= scene->channels.wavelength_nm[i] *
                              rmap_table1_slope(&index, scene->channels.wavelength_nm[i]);
    rmap_reader_warn_outside(reader, inner, "medium", medium->name, column[0][0], column[0][n - 1],
                             "its ends stand for the rest");
    describe(reader, medium, "table of the scene");
    if (!column[2])
        return;
    absorb(scene, &(struct rmap_table1){n, column[0], column[2]}, column[2], medium);
}

static void read_index(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       struct rmap_medium *medium)
{
    double n = 1;
    char text[64];
    (void)rmap_reader_number(reader, node, "index", RMAP_REQUIRED, &range_index, &n);
    for (int i = 0; i < RMAP_CHANNEL_MAX; i++)
        medium->n[i] = medium->n_group[i] = n;
    (void)snprintf(text, sizeof text, "index %.9g", n);
    describe(reader, medium, text);
}

static void read_absorption(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                            struct rmap_medium *medium)
{
    double extra[RMAP_CHANNEL_MAX] = {0};
    const struct rmap_yaml_node *at = rmap_yaml_get(node, "absorption");
    if (!rmap_reader_is_catalogue(at))
        rmap_reader_quantity(reader, node, "absorption", RMAP_OPTIONAL, &rmap_range_attenuation,
                             extra);
    else if (!rmap_yaml_get(node, "glass"))
        rmap_reader_error(reader, at, "'absorption: catalogue' is the absorption of a 'glass'");
    for (int i = 0; i < reader->scene->channels.n; i++) {
        medium->absorption[i] += extra[i];
        medium->absorbing |= medium->absorption[i] > 0;
        medium->dispersive |= medium->n[i] != medium->n[0];
    }
}

static void read_scattering(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                            struct rmap_medium *medium)
{
    const struct rmap_yaml_node *g = rmap_yaml_get(node, "scattering_g");
    if (rmap_reader_is_scattering(rmap_yaml_get(node, "scattering"))) {
        if (g)
            rmap_reader_error(reader, g, "'scattering' is a mapping: its 'g' stands in there");
        return;
    }
    rmap_reader_quantity(reader, node, "scattering", RMAP_OPTIONAL, &rmap_range_attenuation,
                         medium->scattering);
    for (int i = 0; i < reader->scene->channels.n; i++)
        medium->scattering_at_all |= medium->scattering[i] > 0;
    if (g && !rmap_yaml_get(node, "scattering"))
        rmap_reader_error(reader, g,
                          "'scattering_g' says how 'scattering' scatters: give that too");
}

static const struct rmap_range cosine = {-0.9999, 0.9999, "a mean cosine, -0.9999 to 0.9999"};
static const char *const model_key[] = {"index", "glass", "sellmeier", "table", "gradient"};
const struct rmap_mapping rmap_medium_keys = {
    "media",
    NULL,
    {{"a medium", "index glass sellmeier table gradient wavelength_unit absorption scattering "
                  "scattering_g species accounting scintillation"}},
    {{"scattering_g", RMAP_KEY_NUMBER, offsetof(struct rmap_medium, scattering_g), &cosine}}};

static void read_medium(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                        struct rmap_medium *medium)
{
    if (!rmap_reader_known(reader, node, &rmap_medium_keys, 0))
        return;
    (void)rmap_reader_fill(reader, node, &rmap_medium_keys, 0, medium);
    int model = -1, n_model = 0, choice = -1;
    for (int i = 0; i < 5; i++) {
        if (!rmap_yaml_get(node, model_key[i]))
            continue;
        model = i;
        n_model++;
    }
    (void)rmap_reader_choice(reader, node, "wavelength_unit", RMAP_OPTIONAL, "nm um", &choice);
    if (n_model != 1)
        rmap_reader_error(reader, node,
                          "medium '%.60s' needs one of index, glass, sellmeier, table, gradient%s",
                          medium->name, n_model ? ", not several" : "");
    else if (model == 0)
        read_index(reader, node, medium);
    else if (model == 1)
        read_glass(reader, node, medium);
    else if (model == 2)
        read_sellmeier(reader, node, choice == 0 ? 1e-3 : 1.0, medium);
    else if (model == 3)
        read_table(reader, node, choice == 1 ? 1e3 : 1.0, medium);
    else
        rmap_reader_gradient(reader, rmap_yaml_get(node, "gradient"),
                             (int32_t)(medium - reader->scene->medium));
    read_absorption(reader, node, medium);
    read_scattering(reader, node, medium);
    rmap_reader_scintillation(reader, node, medium);
}

static void read_named(struct rmap_reader *reader, const struct rmap_yaml_item *item)
{
    struct rmap_medium *medium = new_medium(reader, item->key, item->line);
    if (medium)
        read_medium(reader, item->value, medium);
}

void rmap_reader_read_media(struct rmap_reader *reader)
{
    rmap_reader_each_named(reader, "media", "medium", &reader->media, read_named);
}

void rmap_reader_medium(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                        const char *key, int32_t *medium_ret)
{
    const char *name = rmap_reader_text(reader, map, key, RMAP_OPTIONAL);
    if (!name)
        return;
    const struct rmap_yaml_node *at = rmap_yaml_get(map, key);
    const struct rmap_name *known = rmap_names_find(&reader->media, name);
    struct rmap_glass glass;
    if (known && medium_ret)
        *medium_ret = known->index;
    if (known || !rmap_reader_find_glass(reader, at, name, &glass) || !medium_ret)
        return;
    struct rmap_medium *medium = new_medium(reader, name, at->line);
    if (!medium)
        return;
    apply_glass(reader, at, &glass, medium);
    for (int i = 0; i < reader->scene->channels.n; i++)
        medium->dispersive |= medium->n[i] != medium->n[0];
    *medium_ret = (int32_t)(reader->scene->n_medium - 1);
}

void rmap_reader_vacuum(struct rmap_reader *reader, int32_t *medium_ret)
{
    struct rmap_medium *medium = new_medium(reader, "vacuum", 0);
    if (!medium)
        return;
    *medium_ret = (int32_t)(reader->scene->n_medium - 1);
    describe(reader, medium, "index 1 (implied)");
}
