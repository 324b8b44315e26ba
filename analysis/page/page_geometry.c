/* SPDX-License-Identifier: MIT */
#include "analysis/figure/tessellation.h"
#include "analysis/page/page_pack.h"
#include "analysis/page/page_parts.h"
#include "base/alloc.h"

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
        bool revolved =
            geometry->kind == RMAP_GEOMETRY_SHAPE && geometry->shape.type != RMAP_SHAPE_RECTANGLE;
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
