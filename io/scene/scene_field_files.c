/* SPDX-License-Identifier: MIT
 *
 * Gradient media from files: grids, which the scene's bundle then carries, and plug-ins, of which
 * it knows the checksum.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "gradient/field_grid.h"
#include "gradient/field_plugin.h"
#include "io/file/input_file.h"
#include "io/scene/scene_channels.h"
#include "io/scene/scene_field.h"
#include "io/scene/scene_geometries.h"

/* ---- grids ---- */

/* Three numbers, or NaN where the scene is silent. */
static bool read_triple(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                        const char *key, double value[3])
{
    size_t n = 0;
    value[0] = value[1] = value[2] = (double)NAN;
    return rmap_reader_numbers(reader, node, key, RMAP_OPTIONAL, &rmap_range_any, 3, 3, value, &n);
}

static bool describe_grid(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                          struct rmap_grid_file *file)
{
    static const char *const axes[] = {"xyz", "xzy", "yxz", "yzx", "zxy", "zyx"};
    const struct rmap_yaml_node *lower = rmap_yaml_get(node, "lower");
    int order = -1;
    double origin[3];
    bool good = read_triple(reader, node, "lower", file->lower);
    good &= read_triple(reader, node, "upper", file->upper);
    good &= read_triple(reader, node, "spacing", file->spacing);
    good &= read_triple(reader, node, "origin", origin);
    const struct rmap_written_unit *unit = rmap_reader_length_unit(reader, node, "unit");
    good &= unit || !rmap_yaml_get(node, "unit");
    good &= rmap_reader_one_of(reader, node, "axes", RMAP_OPTIONAL, axes, RMAP_COUNT(axes), &order);
    if (lower && rmap_yaml_get(node, "origin")) {
        rmap_reader_error(reader, lower, "give 'origin' or 'lower', not both: they are the same");
        good = false;
    } else if (!lower) {
        memcpy(file->lower, origin, sizeof origin);
    }
    if (rmap_yaml_get(node, "upper") && rmap_yaml_get(node, "spacing")) {
        rmap_reader_error(reader, rmap_yaml_get(node, "upper"),
                          "give 'upper' or 'spacing', not both");
        good = false;
    }
    file->dataset = rmap_reader_text(reader, node, "dataset", RMAP_OPTIONAL);
    file->axes = order < 0 ? NULL : axes[order];
    file->length_unit_m = unit ? unit->size : 0;
    file->unit_m = reader->scene->unit_m;
    return good;
}

static void load_grid(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                      const char *name, struct rmap_grid_file *file, struct rmap_grid **grid_ret)
{
    size_t n_hole = 0;
    struct rmap_grid *grid = NULL;
    char *path = rmap_reader_path(reader, name);
    if (!path)
        return;
    file->path = path;
    enum rmap_status st = rmap_grid_read(file, &grid, &n_hole, &reader->failure);
    if (st == RMAP_OK && n_hole)
        rmap_reader_warn(reader, rmap_yaml_get(node, "file"),
                         "the grid has %zu holes (values that are not finite): light that comes "
                         "near one ends there with 'error'",
                         n_hole);
    *grid_ret = grid;
    rmap_reader_made(reader, rmap_yaml_get(node, "file"), st);
}

void rmap_reader_find_grid(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           const char *path, struct rmap_grid **grid_ret)
{
    struct rmap_grid_file file = {0};
    struct rmap_grid *loaded = NULL;
    const char *name = rmap_reader_text(reader, node, "file", RMAP_REQUIRED);
    bool good = describe_grid(reader, node, &file);
    const struct rmap_name *bundled = rmap_names_find(&reader->grids, path);
    *grid_ret = bundled ? reader->bundle->grid[bundled->index].grid : NULL;
    for (size_t i = 0; reader->beside != 0 && !*grid_ret && i < reader->bundle->n_grid; i++)
        if (strcmp(reader->bundle->grid[i].field, path) == 0) /* put there by the first reading */
            *grid_ret = reader->bundle->grid[i].grid;
    if (!name || !good || *grid_ret)
        return;
    if (reader->bundle->meshes_complete) {
        rmap_reader_error(reader, rmap_yaml_get(node, "file"),
                          "the grid of '%.60s' is not stored with the scene", path);
        return;
    }
    load_grid(reader, node, name, &file, &loaded);
    if (!loaded)
        return;
    if (rmap_bundle_add_grid(reader->bundle, path, loaded, &reader->failure) == RMAP_OK) {
        *grid_ret = loaded;
        return;
    }
    rmap_grid_drop(loaded);
    rmap_reader_fail(reader, RMAP_SYSTEM);
}

static void read_grid(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                      const struct rmap_field_place *place, struct rmap_field **field_ret)
{
    struct rmap_grid *grid = NULL;
    double outside = (double)NAN;
    int choice = RMAP_TRICUBIC;
    bool good = rmap_reader_choice(reader, node, "interpolation", RMAP_OPTIONAL,
                                   "trilinear tricubic", &choice);
    good &= rmap_reader_number(reader, node, "outside", RMAP_OPTIONAL, &rmap_range_any, &outside);
    reader->lenient_field = true;
    rmap_reader_find_grid(reader, node, place->path, &grid);
    if (good && grid)
        rmap_reader_made(reader, node,
                         rmap_field_grid(field_ret, grid, (enum rmap_interpolation)choice, outside,
                                         &reader->failure));
}

/* ---- plug-ins ---- */

static bool checksum_file(const char *path, uint64_t *xxh3)
{
    enum { PIECE = 65536 };
    XXH3_state_t *state = XXH3_createState();
    FILE *in = fopen(path, "rb");
    uint8_t *piece = rmap_alloc(PIECE, 1);
    bool good = state && in && piece && XXH3_64bits_reset(state) == XXH_OK;
    for (size_t n = 1; good && n > 0;) {
        n = fread(piece, 1, PIECE, in);
        good = XXH3_64bits_update(state, piece, n) == XXH_OK;
    }
    good = good && !ferror(in);
    *xxh3 = good ? XXH3_64bits_digest(state) : 0;
    rmap_free(piece);
    if (in)
        (void)fclose(in);
    XXH3_freeState(state);
    return good;
}

/* Every rank loads the file that rank 0 has seen. */
static void check_plugin(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                         const char *field, const char *path, bool *good)
{
    struct rmap_bundle *bundle = reader->bundle;
    uint64_t xxh3 = 0;
    const char *trouble = rmap_input_file_trouble(path);
    *good = !trouble && checksum_file(path, &xxh3);
    if (!*good) {
        rmap_reader_error(reader, at,
                          "plug-in '%s' cannot be read: check its name, or build it (%s)", path,
                          trouble ? trouble : "reading failed");
        return;
    }
    *good = bundle->options.allows_plugins || rmap_plugin_is_allowed(path);
    if (!*good) {
        const char *allowing = bundle->options.allowing;
        rmap_reader_error(reader, at,
                          "plug-in '%s' is code, which would run with your rights: it is loaded "
                          "only when you allow it%s%s, or with RAYMAP_ALLOW_PLUGINS=%s in the "
                          "environment",
                          path, allowing ? ": " : "", allowing ? allowing : "", path);
        return;
    }
    for (size_t i = 0; i < bundle->n_plugin; i++) {
        if (strcmp(bundle->plugin[i].field, field) != 0)
            continue;
        *good = bundle->plugin[i].xxh3 == xxh3;
        if (!*good)
            rmap_reader_error(reader, at,
                              "plug-in '%s' is not the same file on all ranks, or has changed: put "
                              "one file where all of them find it",
                              path);
        return;
    }
    if (rmap_bundle_add_plugin(bundle, field, xxh3, &reader->failure) != RMAP_OK)
        rmap_reader_fail(reader, RMAP_SYSTEM);
}

static void load_plugin(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                        const char *field, const struct raymap_field_setup *setup,
                        struct rmap_field **field_ret)
{
    const struct rmap_yaml_node *at = rmap_yaml_get(node, "file");
    char *path = rmap_reader_path(reader, at->text);
    bool good = false;
    if (!path)
        return;
    check_plugin(reader, at, field, path, &good);
    if (good)
        rmap_reader_made(reader, at, rmap_field_plugin(field_ret, path, setup, &reader->failure));
}

static void read_plugin(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                        const struct rmap_field_place *place, struct rmap_field **field_ret)
{
    const struct rmap_yaml_node *list = rmap_yaml_get(node, "parameters");
    const char *name = rmap_reader_text(reader, node, "file", RMAP_REQUIRED);
    bool good = !list || rmap_reader_check_list(reader, list, "'parameters'");
    size_t n = good && list ? list->n_item : 0;
    double *parameter = rmap_reader_alloc(reader, n, sizeof *parameter);
    if (!parameter)
        return;
    reader->lenient_field = true;
    for (size_t i = 0; i < n; i++)
        good &= rmap_reader_scalar(reader, list->item[i].value, "a parameter", &rmap_range_any,
                                   &parameter[i]);
    if (!name || !good)
        return;
    const struct raymap_field_setup setup = {n, parameter,
                                             (size_t)rmap_reader_distinct_wavelengths(reader),
                                             reader->scene->channels.wavelength_nm, place->size};
    if (reader->bundle->loads_plugins)
        load_plugin(reader, node, place->path, &setup, field_ret);
    else
        rmap_reader_made(reader, node,
                         rmap_field_absent(field_ret, (int)setup.n_channel, &reader->failure));
}

/* ---- the table ---- */

static const struct rmap_field_model models[] = {
    {"grid",
     {{0}},
     {"file", "dataset", "axes", "origin", "lower", "upper", "spacing", "unit", "interpolation",
      "outside"},
     NULL,
     read_grid},
    {"plugin", {{0}}, {"file", "parameters"}, NULL, read_plugin},
};

const struct rmap_field_model *rmap_field_model_from_file(size_t i)
{
    return i < RMAP_COUNT(models) ? &models[i] : NULL;
}
