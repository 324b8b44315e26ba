/* SPDX-License-Identifier: MIT
 *
 * The scene as a page has it.
 */
#include <stdio.h>
#include <string.h>

#include "analysis/figure/object_colour.h"
#include "analysis/figure/tessellation.h"
#include "analysis/page/page_pack.h"
#include "analysis/page/page_parts.h"
#include "base/alloc.h"
#include "optics/spectrum.h"
#include "scene/scene_same.h"

static json_t *frame_json(const struct rmap_detector *detector)
{
    return json_pack("{s:o, s:o, s:o, s:o}", "origin", rmap_page_vector(detector->origin), "x",
                     rmap_page_vector(detector->x), "y", rmap_page_vector(detector->y), "axis",
                     rmap_page_vector(detector->axis));
}

/* [n_vertex][3], parts of the box from `low` by `size`. */
static uint16_t *quantised(const struct rmap_mesh *mesh, const double low[3], const double size[3])
{
    uint16_t *place = rmap_alloc(3 * mesh->n_vertex + 1, sizeof *place);
    for (size_t i = 0; place && i < mesh->n_vertex; i++)
        for (int k = 0; k < 3; k++) {
            double part = size[k] > 0.0 ? ((double)mesh->vertex[i][k] - low[k]) / size[k] : 0.0;
            place[3 * i + (size_t)k] = (uint16_t)(65535.0 * fmin(fmax(part, 0.0), 1.0) + 0.5);
        }
    return place;
}

static int32_t *corners(const struct rmap_mesh *mesh)
{
    int32_t *corner = rmap_alloc(3 * mesh->n_triangle + 1, sizeof *corner);
    for (size_t i = 0; corner && i < 3 * mesh->n_triangle; i++)
        corner[i] = (int32_t)mesh->triangle[i / 3][i % 3];
    return corner;
}

static json_t *mesh_json(const struct rmap_mesh *mesh)
{
    struct rmap_vec3 lower, upper;
    json_t *json = NULL;
    rmap_mesh_bounds(mesh, &lower, &upper);
    const double low[3] = {lower.x, lower.y, lower.z};
    const double size[3] = {upper.x - lower.x, upper.y - lower.y, upper.z - lower.z};
    uint16_t *place = quantised(mesh, low, size);
    int32_t *corner = corners(mesh);
    if (place && corner)
        json = json_pack("{s:[f, f, f], s:[f, f, f], s:o, s:o}", "low", low[0], low[1], low[2],
                         "size", size[0], size[1], size[2], "place",
                         rmap_page_shorts(place, 3 * mesh->n_vertex), "corner",
                         rmap_page_integers(corner, 3 * mesh->n_triangle));
    rmap_free(place);
    rmap_free(corner);
    return json;
}

/* Radius and height of every ring: the page turns them about the axis itself. */
static json_t *profile_json(const struct rmap_mesh *mesh)
{
    size_t n = mesh->n_vertex / RMAP_FACETS;
    float *profile = rmap_alloc(2 * n + 1, sizeof *profile);
    for (size_t i = 0; profile && i < n; i++) {
        profile[2 * i] = mesh->vertex[i * RMAP_FACETS][0];
        profile[2 * i + 1] = mesh->vertex[i * RMAP_FACETS][2];
    }
    json_t *json = profile ? json_pack("{s:i, s:o}", "facets", RMAP_FACETS, "profile",
                                       rmap_page_floats(profile, 2 * n))
                           : NULL;
    rmap_free(profile);
    return json;
}

json_t *rmap_page_geometries(const struct rmap_scene *scene, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_mesh *mesh = NULL;
    json_t *list = json_array(), *json;
    for (size_t g = 0; g < scene->n_geometry; g++) {
        const struct rmap_geometry *geometry = &scene->geometry[g];
        if (geometry->kind == RMAP_GEOMETRY_SHAPE)
            RMAP_TRY(rmap_shape_tessellate(&geometry->shape, &mesh, err));
        else
            RMAP_TRY(rmap_mesh_weld(geometry->mesh, &mesh, err));
        bool revolved = geometry->kind == RMAP_GEOMETRY_SHAPE &&
                        rmap_shape_model[geometry->shape.type].revolved;
        json = revolved ? profile_json(mesh) : mesh_json(mesh);
        if (!json || json_array_append_new(list, json) != 0)
            RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for the scene of a page"));
        rmap_mesh_destroy(mesh);
        mesh = NULL;
    }
out:
    rmap_mesh_destroy(mesh);
    if (st == RMAP_OK)
        return list;
    json_decref(list);
    return NULL;
}

/* Row by row, as in the scene file. */
static json_t *matrix(const struct rmap_affine *a)
{
    return json_pack("[f, f, f, f, f, f, f, f, f, f, f, f]", a->m[0][0], a->m[0][1], a->m[0][2],
                     a->t.x, a->m[1][0], a->m[1][1], a->m[1][2], a->t.y, a->m[2][0], a->m[2][1],
                     a->m[2][2], a->t.z);
}

static json_t *media(const struct rmap_scene *scene)
{
    json_t *list = json_array();
    for (size_t i = 0; i < scene->n_medium; i++)
        json_array_append_new(list, rmap_page_string(scene->medium[i].name));
    return list;
}

static json_t *groups(const struct rmap_scene *scene)
{
    json_t *list = json_array();
    for (size_t i = 0; i < scene->n_group; i++)
        json_array_append_new(list, json_pack("{s:o, s:i}", "name",
                                              rmap_page_string(scene->group[i].name), "parent",
                                              (int)scene->group[i].parent));
    return list;
}

static const char *look_of(const struct rmap_scene *scene, const struct rmap_object *object)
{
    if (rmap_scene_transmits(scene, object->surface_front) ||
        rmap_scene_transmits(scene, object->surface_back))
        return "glass";
    return rmap_surface_look(&scene->surface[object->surface_front]) == RMAP_LOOK_MIRROR ? "metal"
                                                                                         : "opaque";
}

static json_t *objects(const struct rmap_scene *scene)
{
    double(*rgb)[3] = rmap_object_colours(scene);
    json_t *list = rgb ? json_array() : NULL;
    for (size_t i = 0; rgb && i < scene->n_object; i++) {
        const struct rmap_object *object = &scene->object[i];
        const struct rmap_surface *surface = &scene->surface[object->surface_front];
        json_array_append_new(
            list, json_pack("{s:o, s:i, s:i, s:o, s:s, s:[f, f, f], s:o}", "name",
                            rmap_page_string(object->name), "parent", (int)object->parent,
                            "geometry", (int)object->geometry, "matrix", matrix(&object->to_world),
                            "look", look_of(scene, object), "albedo", rgb[i][0], rgb[i][1],
                            rgb[i][2], "surface", rmap_page_string(surface->name)));
    }
    rmap_free(rgb);
    return list;
}

static const char *emitter_word(const struct rmap_source *source)
{
    static const char *const word[] = {"point", "disc", "rectangle", "mesh", "rectangle", "sky"};
    return rmap_source_is_of_rays(source) ? "rays" : word[source->shape];
}

static json_t *sources(const struct rmap_scene *scene)
{
    json_t *list = json_array();
    for (size_t i = 0; i < scene->n_source; i++) {
        const struct rmap_source *source = &scene->source[i];
        struct rmap_affine place = source->frame;
        const double *size =
            source->shape == RMAP_EMITTER_BODY ? source->lamp->size : source->shape_size;
        place.t = rmap_source_place(scene, source);
        json_array_append_new(list, json_pack("{s:o, s:s, s:[f, f], s:o, s:f}", "name",
                                              rmap_page_string(source->name), "shape",
                                              emitter_word(source), "size", size[0], size[1],
                                              "matrix", matrix(&place), "flux", source->flux));
    }
    return list;
}

static bool same_counts(const struct rmap_scene *a, const struct rmap_scene *b)
{
    return a->n_object == b->n_object && a->n_group == b->n_group && a->n_source == b->n_source &&
           a->n_detector == b->n_detector && a->n_geometry == b->n_geometry &&
           a->n_surface == b->n_surface && a->n_medium == b->n_medium;
}

json_t *rmap_page_places(const struct rmap_scene *before, const struct rmap_scene *after)
{
    const struct rmap_scene_pair pair = {.old = before, .new = after};
    if (!same_counts(before, after))
        return NULL;
    /* Files of meshes, surfaces and media may be others by now. */
    for (size_t g = 0; g < after->n_geometry; g++)
        if (!rmap_same_geometry(&pair, (int32_t)g, (int32_t)g))
            return NULL;
    for (size_t s = 0; s < after->n_surface; s++)
        if (!rmap_same_surface(&pair, (int32_t)s, (int32_t)s))
            return NULL;
    for (size_t m = 0; m < after->n_medium; m++)
        if (!rmap_same_medium(&pair, (int32_t)m, (int32_t)m))
            return NULL;
    json_t *moved = json_object(), *frames = json_array();
    char index[24];
    for (size_t i = 0; i < after->n_object; i++) {
        const struct rmap_affine *to = &after->object[i].to_world;
        if (memcmp(to, &before->object[i].to_world, sizeof *to) == 0)
            continue;
        (void)snprintf(index, sizeof index, "%zu", i);
        (void)json_object_set_new(moved, index, matrix(to));
    }
    for (size_t d = 0; d < after->n_detector; d++)
        (void)json_array_append_new(frames, frame_json(&after->detector[d]));
    return json_pack("{s:o, s:o, s:o, s:o, s:f}", "objects", moved, "sources", sources(after),
                     "detectors", frames, "centre", rmap_page_vector(after->centre), "radius",
                     after->radius);
}

static json_t *wavelengths(const struct rmap_scene *scene)
{
    json_t *list = json_array();
    for (int c = 0; c < scene->channels.n; c++)
        json_array_append_new(list, json_real(scene->channels.wavelength_nm[c]));
    return list;
}

json_t *rmap_page_scene(const struct rmap_scene *scene, struct rmap_error *err)
{
    json_t *json =
        json_pack("{s:o, s:s, s:s, s:o, s:o, s:f, s:o, s:o, s:o, s:o}", "unit",
                  rmap_page_string(scene->unit), "flux_unit", rmap_flux_unit_name(scene), "mode",
                  scene->channels.mode == RMAP_COLOUR_RGB ? "rgb" : "spectral", "wavelengths",
                  wavelengths(scene), "centre", rmap_page_vector(scene->centre), "radius",
                  scene->radius, "media", media(scene), "groups", groups(scene), "objects",
                  objects(scene), "sources", sources(scene));
    if (!json)
        (void)rmap_error_set(err, RMAP_SYSTEM, "out of memory for the scene of a page");
    return json;
}
