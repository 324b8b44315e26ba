/* SPDX-License-Identifier: MIT
 *
 * The lower level: trees of meshes.
 */
#include "accel/accel_bottom.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "accel/accel_build.h"
#include "accel/accel_cell.h"
#include "accel/accel_triangle.h"
#include "base/alloc.h"
#include "scene/scene_same.h"

/* The triangles around each vertex of a mesh. Vertices at the same place are one, whether or not
 * the file shared them. */

/* A ray begins this share of the float error that it may be off behind its start: see
 * RMAP_REACH_ERRORS. */
#define LEAST_COSINE (4.0 / RMAP_REACH_ERRORS)

static bool same_place(const float a[3], const float b[3])
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

/* The same of both zeros. */
static size_t hash_of(const float at[3])
{
    uint64_t hash = 0;
    for (int k = 0; k < 3; k++) {
        const float number = at[k] + 0.0f;
        uint32_t bits;
        memcpy(&bits, &number, sizeof bits);
        hash = (hash ^ bits) * 0x9E3779B97F4A7C15u;
        hash ^= hash >> 32;
    }
    return (size_t)hash;
}

/* same[v]: the first vertex at the place of v. Slots of a table hold vertices plus 1. */
static bool join_vertices(const struct rmap_mesh *mesh, uint32_t *same)
{
    size_t n_slot = 4;
    while (n_slot < 2 * mesh->n_vertex)
        n_slot *= 2;
    uint32_t *slot = rmap_alloc(n_slot, sizeof *slot);
    if (!slot)
        return false;
    for (size_t i = 0; i < mesh->n_vertex; i++) {
        size_t at = hash_of(mesh->vertex[i]) & (n_slot - 1);
        while (slot[at] && !same_place(mesh->vertex[slot[at] - 1], mesh->vertex[i]))
            at = (at + 1) & (n_slot - 1);
        if (!slot[at])
            slot[at] = (uint32_t)i + 1;
        same[i] = slot[at] - 1;
    }
    rmap_free(slot);
    return true;
}

/* At RMAP_NEEDLE_SINE a triangle is not wide enough to be safe from any side. */
static void set_sight(const struct rmap_facets *facets, size_t i, double wider, float sight[4])
{
    struct rmap_vec3 corner[3];
    rmap_facets_corners(facets, (int32_t)i, corner);
    struct rmap_vec3 e1 = rmap_sub(corner[1], corner[0]), e2 = rmap_sub(corner[2], corner[0]);
    struct rmap_vec3 e0 = rmap_sub(e2, e1), n = rmap_cross(e1, e2);
    const double side[3] = {rmap_length(e0), rmap_length(e1), rmap_length(e2)};
    double area = rmap_length(n), cosine = HUGE_VAL;
    double longest = rmap_max(side[0], rmap_max(side[1], side[2]));
    if (area > RMAP_NEEDLE_SINE * longest * longest) {
        const double margin = rmap_facet_margin(area, side[0] + side[1] + side[2], wider);
        cosine = rmap_max(wider / margin, LEAST_COSINE) * (1 + 1e-5);
        n = rmap_scale(n, 1 / area);
    }
    sight[0] = (float)n.x;
    sight[1] = (float)n.y;
    sight[2] = (float)n.z;
    sight[3] = (float)cosine;
}

static enum rmap_status facets_build(const struct rmap_mesh *mesh, double wider,
                                     struct rmap_facets *facets, struct rmap_error *err)
{
    facets->same = rmap_alloc_unset(mesh->n_vertex, sizeof(*facets->same));
    facets->first = rmap_alloc(mesh->n_vertex + 2, sizeof(*facets->first));
    facets->fan = rmap_alloc_unset(3 * mesh->n_triangle, sizeof(*facets->fan));
    facets->corner = rmap_alloc_unset(mesh->n_triangle, sizeof(*facets->corner));
    facets->sight = rmap_alloc_unset(mesh->n_triangle, sizeof(*facets->sight));
    if (!facets->corner || !facets->sight || !facets->same || !facets->first || !facets->fan ||
        !join_vertices(mesh, facets->same))
        return rmap_error_set(err, RMAP_SYSTEM, "no memory for a mesh of %zu triangles",
                              mesh->n_triangle);
    for (size_t i = 0; i < mesh->n_triangle; i++)
        for (int k = 0; k < 3; k++)
            memcpy(&facets->corner[i][3 * k], mesh->vertex[mesh->triangle[i][k]],
                   sizeof(*mesh->vertex));
    /* counts two places on, so that filling them leaves the starts where they belong */
    for (size_t i = 0; i < mesh->n_triangle; i++)
        for (int k = 0; k < 3; k++)
            facets->first[facets->same[mesh->triangle[i][k]] + 2]++;
    for (size_t v = 2; v < mesh->n_vertex + 2; v++)
        facets->first[v] += facets->first[v - 1];
    for (size_t i = 0; i < mesh->n_triangle; i++)
        for (int k = 0; k < 3; k++)
            facets->fan[facets->first[facets->same[mesh->triangle[i][k]] + 1]++] = (uint32_t)i;
    for (size_t i = 0; i < mesh->n_triangle; i++)
        set_sight(facets, i, wider, facets->sight[i]);
    return RMAP_OK;
}

static void facets_release(struct rmap_facets *facets)
{
    rmap_free(facets->corner);
    rmap_free(facets->sight);
    rmap_free(facets->same);
    rmap_free(facets->first);
    rmap_free(facets->fan);
    rmap_cells_destroy(facets->cells);
}

static void drop(struct rmap_bottom *bottom)
{
    if (!bottom || bottom->n_more-- > 0)
        return;
    facets_release(&bottom->facets);
    if (bottom->scene)
        rtcReleaseScene(bottom->scene);
    rmap_free(bottom->widened);
    rmap_mesh_destroy(bottom->mesh);
    rmap_free(bottom);
}

void rmap_bottoms_release(struct rmap_accel *accel)
{
    for (size_t i = 0; accel->bottom && i < accel->n_bottom; i++)
        drop(accel->bottom[i]);
    rmap_free(accel->bottom);
}

/* Triangles are widened by the float error and the rounding of the widened corners. */
static enum rmap_status build(struct rmap_accel *accel, const struct rmap_geometry *geometry,
                              struct rmap_bottom **bottom_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_vec3 lower, upper;
    rmap_mesh_bounds(geometry->mesh, &lower, &upper);
    const double reach = rmap_mesh_rounding(lower, upper);
    const double wider = RMAP_LOCAL_ERRORS * reach + 2 * reach;
    if (!(wider > 0) || geometry->mesh->n_triangle == 0)
        return RMAP_OK;
    struct rmap_bottom *bottom = rmap_alloc(1, sizeof(*bottom));
    if (!bottom)
        return rmap_error_set(err, RMAP_SYSTEM, "no memory for a mesh");
    *bottom_ret = bottom;
    bottom->mesh = rmap_mesh_hold(geometry->mesh);
    bottom->lower = lower;
    bottom->upper = upper;
    if (geometry->mesh->surface) {
        const struct rmap_mesh whole = rmap_mesh_with_beyond(geometry->mesh);
        RMAP_TRY(facets_build(&whole, wider, &bottom->facets, err));
        RMAP_TRY(
            rmap_cells_build(geometry->mesh, &bottom->facets, wider, &bottom->facets.cells, err));
        RMAP_TRY(rmap_accel_cells(accel, bottom->facets.cells, &bottom->scene, err));
    } else {
        RMAP_TRY(rmap_accel_mesh(accel, geometry, wider, &bottom->scene, &bottom->widened, err));
        RMAP_TRY(facets_build(geometry->mesh, wider, &bottom->facets, err));
    }
    accel->build.n_built++;
out:
    return st;
}

/* Meshes that may be the same are neighbours. */
static int by_contents(const struct rmap_mesh *a, const struct rmap_mesh *b)
{
    if (a == b)
        return 0;
    if (a->n_triangle != b->n_triangle)
        return a->n_triangle < b->n_triangle ? -1 : 1;
    if (a->n_vertex != b->n_vertex)
        return a->n_vertex < b->n_vertex ? -1 : 1;
    const int order = memcmp(a->vertex, b->vertex, a->n_vertex * sizeof(*a->vertex));
    return order ? order : memcmp(a->triangle, b->triangle, a->n_triangle * sizeof(*a->triangle));
}

static int compare_bottoms(const void *left, const void *right)
{
    struct rmap_bottom *const *a = left, *const *b = right;
    return by_contents((*a)->mesh, (*b)->mesh);
}

/* What there is of another structure: by geometry, and once it was asked for, by contents. */
struct stock {
    const struct rmap_accel *like;
    struct rmap_bottom **sorted;
    size_t n;
};

static enum rmap_status sort_stock(struct stock *stock, struct rmap_error *err)
{
    stock->sorted = rmap_alloc(stock->like->n_bottom, sizeof(struct rmap_bottom *));
    if (!stock->sorted)
        return rmap_error_set(err, RMAP_SYSTEM, "no memory for %zu meshes", stock->like->n_bottom);
    for (size_t i = 0; i < stock->like->n_bottom; i++)
        if (stock->like->bottom[i])
            stock->sorted[stock->n++] = stock->like->bottom[i];
    qsort(stock->sorted, stock->n, sizeof(struct rmap_bottom *), compare_bottoms);
    return RMAP_OK;
}

static enum rmap_status take_over(struct stock *stock, size_t i, struct rmap_mesh *mesh,
                                  struct rmap_bottom **bottom_ret, struct rmap_error *err)
{
    const struct rmap_accel *like = stock->like;
    enum rmap_status st = RMAP_OK;
    struct rmap_bottom *found = i < like->n_bottom ? like->bottom[i] : NULL;
    if (!found || !rmap_same_mesh(found->mesh, mesh)) {
        struct rmap_bottom key = {.mesh = mesh}, *wanted = &key, **place;
        if (!stock->sorted)
            RMAP_TRY(sort_stock(stock, err));
        place = bsearch(&wanted, stock->sorted, stock->n, sizeof wanted, compare_bottoms);
        found = place && rmap_same_mesh((*place)->mesh, mesh) ? *place : NULL;
    }
    if (found)
        found->n_more++;
    *bottom_ret = found;
out:
    return st;
}

static enum rmap_status make_one(struct rmap_accel *accel, struct stock *stock, size_t i,
                                 const struct rmap_geometry *geometry, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (stock->like)
        RMAP_TRY(take_over(stock, i, geometry->mesh, &accel->bottom[i], err));
    if (accel->bottom[i])
        accel->build.n_kept++;
    else
        RMAP_TRY(build(accel, geometry, &accel->bottom[i], err));
out:
    return st;
}

enum rmap_status rmap_bottoms_build(struct rmap_accel *accel, const struct rmap_scene *scene,
                                    const struct rmap_accel *like, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct stock stock = {.like = like};
    bool *used = rmap_alloc(scene->n_geometry, sizeof(*used));
    accel->bottom = rmap_alloc(scene->n_geometry, sizeof(struct rmap_bottom *));
    accel->n_bottom = scene->n_geometry;
    if (!used || !accel->bottom)
        RMAP_TRY(
            rmap_error_set(err, RMAP_SYSTEM, "no memory for %zu geometries", scene->n_geometry));
    for (size_t i = 0; i < scene->n_object; i++)
        used[scene->object[i].geometry] = true;
    for (size_t i = 0; i < scene->n_geometry; i++)
        if (used[i] && scene->geometry[i].kind == RMAP_GEOMETRY_MESH)
            RMAP_TRY(make_one(accel, &stock, i, &scene->geometry[i], err));
out:
    rmap_free(stock.sorted);
    rmap_free(used);
    return st;
}
