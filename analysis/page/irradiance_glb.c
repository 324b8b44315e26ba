/* SPDX-License-Identifier: MIT
 *
 * Objects in false colours of what their cells have as glTF.
 */
#include "analysis/page/irradiance_glb.h"

#include <string.h>
#include <strings.h>

#include "base/alloc.h"
#include "io/export/glb.h"
#include "io/file/whole_file.h"

/* Of an object: a point for each corner of a facet. */
struct points {
    size_t n, n_triangle;
    float (*at)[3];
    uint16_t (*colour)[4];
    float *value;
    uint32_t (*triangle)[3];
};

static void fini(struct points *points)
{
    rmap_free(points->at);
    rmap_free(points->colour);
    rmap_free(points->value);
    rmap_free(points->triangle);
}

static enum rmap_status init(const struct rmap_irradiance_cells *cells, size_t part,
                             struct points *points, struct rmap_error *err)
{
    const struct rmap_irradiance_part *of = &cells->part[part];
    size_t n = 0;
    for (size_t f = of->first_facet; f < of->first_facet + of->n_facet; f++)
        n += cells->facet[f].n_corner;
    *points = (struct points){.at = rmap_alloc(n + 1, sizeof *points->at),
                              .colour = rmap_alloc(n + 1, sizeof *points->colour),
                              .value = rmap_alloc(n + 1, sizeof *points->value),
                              .triangle = rmap_alloc(n + 1, sizeof *points->triangle)};
    return points->at && points->colour && points->value && points->triangle
               ? RMAP_OK
               : rmap_error_set(err, RMAP_SYSTEM, "out of memory for a glTF scene");
}

static void add_facet(const struct rmap_figure_cells *painted, const struct rmap_colour_map *map,
                      const struct rmap_irradiance_facet *facet, struct points *points)
{
    const size_t c = facet->cell;
    const uint32_t first = (uint32_t)points->n;
    uint8_t rgb[3];
    rmap_colour_map_at(map, rmap_colour_bar_place(&painted->bar, painted->value[c]), rgb);
    for (uint32_t k = 0; k < facet->n_corner; k++) {
        const struct rmap_vec3 p = painted->cells->corner[facet->corner + k];
        const float at[3] = {(float)p.x, (float)p.y, (float)p.z};
        memcpy(points->at[points->n], at, sizeof at);
        for (int i = 0; i < 3; i++)
            points->colour[points->n][i] = (uint16_t)(65535.0 * rmap_srgb_linear(rgb[i]) + 0.5);
        points->colour[points->n][3] = UINT16_MAX;
        points->value[points->n++] = (float)painted->value[c];
    }
    for (uint32_t k = 2; k < facet->n_corner; k++) {
        const uint32_t turn = painted->side == RMAP_SIDE_BACK;
        const uint32_t corner[3] = {first, first + k - 1 + turn, first + k - turn};
        memcpy(points->triangle[points->n_triangle++], corner, sizeof corner);
    }
}

static enum rmap_status add_object(const struct rmap_figure_cells *painted,
                                   const struct rmap_colour_map *map, size_t part, size_t material,
                                   struct rmap_glb *glb, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_irradiance_cells *cells = painted->cells;
    const struct rmap_irradiance_part *of = &cells->part[part];
    const char *name = cells->scene->object[of->object].name;
    struct rmap_glb_shape shape;
    struct points points = {0};
    size_t mesh = 0;
    RMAP_TRY(init(cells, part, &points, err));
    for (size_t f = of->first_facet; f < of->first_facet + of->n_facet; f++)
        add_facet(painted, map, &cells->facet[f], &points);
    RMAP_TRY(rmap_glb_add_shape(glb, (const float(*)[3])points.at, points.n,
                                (const uint32_t(*)[3])points.triangle, points.n_triangle, &shape,
                                err));
    const struct rmap_glb_paint paint = {(const uint16_t(*)[4])points.colour, points.value,
                                         "_VALUE", points.n};
    RMAP_TRY(rmap_glb_add_painted(glb, name, &shape, &paint, material, &mesh, err));
    st = rmap_glb_place(glb, name, mesh, NULL, err);
out:
    fini(&points);
    return st;
}

enum rmap_status rmap_irradiance_glb_write(const struct rmap_figure_cells *painted,
                                           const char *path, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = painted->cells->scene;
    struct rmap_whole_file whole = {0};
    struct rmap_glb *glb = NULL;
    struct rmap_colour_map map;
    char name[200];
    size_t material = 0;
    rmap_colour_map_init(&map);
    (void)snprintf(name, sizeof name, "%s in %s, %s from %.4g to %.4g", painted->bar.label,
                   painted->bar.unit, painted->bar.logarithmic ? "logarithmic" : "linear",
                   painted->bar.range[0], painted->bar.range[1]);
    const struct rmap_glb_material plain = {.name = name,
                                            .colour = {1, 1, 1, 1},
                                            .roughness = 1,
                                            .unlit = 1,
                                            .one_sided = painted->side != RMAP_SIDE_BOTH};
    RMAP_TRY(rmap_glb_create(scene->unit_m, rmap_view_has_z_upright(scene), &glb, err));
    RMAP_TRY(rmap_glb_add_material(glb, &plain, &material, err));
    for (size_t p = 0; p < painted->cells->n_part; p++)
        RMAP_TRY(add_object(painted, &map, p, material, glb, err));
    RMAP_TRY(rmap_whole_file_open(&whole, path, err));
    const char *suffix = strrchr(path, '.');
    RMAP_TRY(suffix && strcasecmp(suffix, ".gltf") == 0 ? rmap_gltf_write(glb, whole.file, err)
                                                        : rmap_glb_write(glb, whole.file, err));
    st = rmap_whole_file_finish(&whole, err);
out:
    rmap_whole_file_fini(&whole);
    rmap_glb_destroy(glb);
    return st;
}
