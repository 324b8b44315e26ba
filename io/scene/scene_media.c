/* SPDX-License-Identifier: MIT
 *
 * Media: refractive index and absorption on the scene's channels.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "io/scene/scene_channels.h"
#include "io/scene/scene_keys.h"
#include "io/scene/scene_media.h"
#include "optics/dispersion.h"

static const struct rmap_range range_index = {1e-3, 1e3, "a refractive index, 0.001 to 1000"};

static struct rmap_medium *new_medium(struct rmap_reader *reader, const char *name, int32_t line)
{
    struct rmap_scene *scene = reader->scene;
    struct rmap_medium *medium =
        RMAP_READER_NEW(reader, scene->medium, scene->n_medium, reader->cap_medium);
    if (!medium)
        return NULL;
    for (int i = 0; i < RMAP_CHANNEL_MAX; i++)
        medium->n[i] = 1;
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

static void warn_outside(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                         const char *name, double from_nm, double to_nm, const char *consequence)
{
    const struct rmap_channels *channels = &reader->scene->channels;
    double first = channels->wavelength_nm[0], last = channels->wavelength_nm[channels->n - 1];
    double slack = 1e-6 * last;
    if (first < from_nm - slack || last > to_nm + slack)
        rmap_reader_warn(reader, at,
                         "medium '%.60s' is known from %g to %g nm, the scene has light from %g "
                         "to %g nm: %s",
                         name, from_nm, to_nm, first, last, consequence);
}

static void evaluate_sellmeier(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                               const struct rmap_sellmeier *sellmeier, struct rmap_medium *medium)
{
    const struct rmap_channels *channels = &reader->scene->channels;
    for (int i = 0; i < channels->n; i++) {
        double n = rmap_sellmeier_index(sellmeier, channels->wavelength_nm[i]);
        if (n >= range_index.from && n <= range_index.to) {
            medium->n[i] = n;
            continue;
        }
        rmap_reader_error(reader, at,
                          "medium '%.60s' has no real refractive index at %g nm: check B and C "
                          "(and wavelength_unit), or leave the wavelength out",
                          medium->name, channels->wavelength_nm[i]);
        return;
    }
}

static void apply_glass(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                        const struct rmap_glass *glass, struct rmap_medium *medium)
{
    char text[400];
    evaluate_sellmeier(reader, at, &glass->sellmeier, medium);
    warn_outside(reader, at, medium->name, glass->from_nm, glass->to_nm,
                 "its formula is extrapolated");
    (void)snprintf(text, sizeof text, "%s (Sellmeier; %s)", glass->name, glass->source);
    describe(reader, medium, text);
}

const struct rmap_glass *rmap_reader_glass(struct rmap_reader *reader,
                                           const struct rmap_yaml_node *node)
{
    enum { LISTED = 256 };
    const char *name = rmap_reader_text(reader, node, "glass", RMAP_REQUIRED);
    const struct rmap_yaml_node *at = rmap_yaml_get(node, "glass");
    const struct rmap_glass *glass = name ? rmap_glass_find(name) : NULL;
    if (glass || !name)
        return glass;
    const char *known[LISTED];
    size_t n = 0;
    for (const struct rmap_glass *g; n < LISTED && (g = rmap_glass_at(n)) != NULL; n++)
        known[n] = g->name;
    rmap_reader_unknown(reader, at->line, at->column, "unknown glass", name, known, n);
    return NULL;
}

static void read_glass(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       struct rmap_medium *medium)
{
    const struct rmap_glass *glass = rmap_reader_glass(reader, node);
    if (glass)
        apply_glass(reader, rmap_yaml_get(node, "glass"), glass, medium);
}

bool rmap_reader_sellmeier(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           double unit_um, struct rmap_sellmeier *sellmeier)
{
    size_t n_b = 0, n_c = 0;
    *sellmeier = (struct rmap_sellmeier){0};
    if (!rmap_reader_check_map(reader, node, "sellmeier", "B C"))
        return false;
    bool good = rmap_reader_numbers(reader, node, "B", RMAP_REQUIRED, &rmap_range_any, 1,
                                    RMAP_SELLMEIER_MAX, sellmeier->b, &n_b);
    good &= rmap_reader_numbers(reader, node, "C", RMAP_REQUIRED, &rmap_range_any, 1,
                                RMAP_SELLMEIER_MAX, sellmeier->c, &n_c);
    if (good && n_b != n_c)
        rmap_reader_error(reader, node, "B has %zu coefficients, C has %zu", n_b, n_c);
    if (!good || n_b != n_c)
        return false;
    sellmeier->n_term = n_b;
    for (size_t i = 0; i < n_c; i++)
        sellmeier->c[i] *= unit_um * unit_um;
    return true;
}

static void read_sellmeier(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           double unit_um, struct rmap_medium *medium)
{
    const struct rmap_yaml_node *inner = rmap_yaml_get(node, "sellmeier");
    struct rmap_sellmeier sellmeier;
    if (!rmap_reader_sellmeier(reader, inner, unit_um, &sellmeier))
        return;
    evaluate_sellmeier(reader, inner, &sellmeier, medium);
    describe(reader, medium, "Sellmeier coefficients of the scene");
}

/* Absorption per length unit of k: 4 pi k / lambda (Born & Wolf, 7th ed., 14.1). */
static double absorption_of_k(const struct rmap_scene *scene, double k, double wavelength_nm)
{
    return 4.0 * RMAP_PI * k / (wavelength_nm * 1e-9 / scene->unit_m);
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
        medium->n[i] = rmap_table1_at(&index, scene->channels.wavelength_nm[i]);
    warn_outside(reader, inner, medium->name, column[0][0], column[0][n - 1],
                 "its ends stand for the rest");
    describe(reader, medium, "table of the scene");
    if (!column[2])
        return;
    struct rmap_spectrum k = {.kind = RMAP_SPECTRUM_TABLE, .table = {n, column[0], column[2]}};
    if (scene->channels.mode == RMAP_COLOUR_SPECTRAL) {
        rmap_spectrum_sample(&k, &scene->channels, medium->absorption);
        for (int i = 0; i < scene->channels.n; i++)
            medium->absorption[i] =
                absorption_of_k(scene, medium->absorption[i], scene->channels.wavelength_nm[i]);
        return;
    }
    for (size_t i = 0; i < n; i++)
        column[2][i] = absorption_of_k(scene, column[2][i], column[0][i]);
    rmap_spectrum_sample(&k, &scene->channels, medium->absorption);
}

static void read_index(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       struct rmap_medium *medium)
{
    double n = 1;
    char text[64];
    (void)rmap_reader_number(reader, node, "index", RMAP_REQUIRED, &range_index, &n);
    for (int i = 0; i < RMAP_CHANNEL_MAX; i++)
        medium->n[i] = n;
    (void)snprintf(text, sizeof text, "index %.9g", n);
    describe(reader, medium, text);
}

static void read_absorption(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                            struct rmap_medium *medium)
{
    double extra[RMAP_CHANNEL_MAX] = {0};
    rmap_reader_quantity(reader, node, "absorption", RMAP_OPTIONAL, &rmap_range_attenuation, extra);
    for (int i = 0; i < reader->scene->channels.n; i++) {
        medium->absorption[i] += extra[i];
        medium->absorbing |= medium->absorption[i] > 0;
        medium->dispersive |= medium->n[i] != medium->n[0];
    }
}

static void check_scattering(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                             struct rmap_medium *medium)
{
    for (int i = 0; i < reader->scene->channels.n; i++)
        medium->scattering_at_all |= medium->scattering[i] > 0;
    if (rmap_yaml_get(node, "scattering_g") && !rmap_yaml_get(node, "scattering"))
        rmap_reader_error(reader, rmap_yaml_get(node, "scattering_g"),
                          "'scattering_g' says how 'scattering' scatters: give that too");
}

static const struct rmap_range cosine = {-0.9999, 0.9999, "a mean cosine, -0.9999 to 0.9999"};
static const char *const model_key[] = {"index", "glass", "sellmeier", "table", "gradient"};
const struct rmap_mapping rmap_medium_keys = {
    "media",
    NULL,
    {{"a medium", "index glass sellmeier table gradient wavelength_unit absorption scattering "
                  "scattering_g"}},
    {{"scattering", RMAP_KEY_SHARES, offsetof(struct rmap_medium, scattering),
      &rmap_range_attenuation},
     {"scattering_g", RMAP_KEY_NUMBER, offsetof(struct rmap_medium, scattering_g), &cosine}}};

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
    check_scattering(reader, node, medium);
}

void rmap_reader_read_media(struct rmap_reader *reader)
{
    const struct rmap_yaml_node *media = rmap_yaml_get(reader->root, "media");
    if (!media)
        return;
    if (media->kind != RMAP_YAML_MAP) {
        rmap_reader_error(reader, media, "media must be a mapping {name: medium, ...}");
        return;
    }
    for (size_t i = 0; i < media->n_item; i++) {
        const struct rmap_yaml_item *item = &media->item[i];
        const struct rmap_yaml_node place = {.line = item->line, .column = item->column};
        if (rmap_names_find(&reader->media, item->key) ||
            !rmap_reader_check_name(reader, &place, item->key))
            continue;
        struct rmap_medium *medium = new_medium(reader, item->key, item->line);
        if (medium)
            read_medium(reader, item->value, medium);
    }
}

void rmap_reader_medium(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                        const char *key, int32_t *medium_ret)
{
    const char *name = rmap_reader_text(reader, map, key, RMAP_OPTIONAL);
    if (!name)
        return;
    const struct rmap_yaml_node *at = rmap_yaml_get(map, key);
    const struct rmap_glass *glass = rmap_glass_find(name);
    if (!glass || rmap_names_find(&reader->media, name)) {
        *medium_ret = rmap_reader_find(reader, &reader->media, "medium", at, name);
        return;
    }
    struct rmap_medium *medium = new_medium(reader, name, at->line);
    if (!medium)
        return;
    apply_glass(reader, at, glass, medium);
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
