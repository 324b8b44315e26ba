/* SPDX-License-Identifier: MIT
 *
 * The lower level: those of all meshes, shared with structures that have the same.
 */
#include "accel/accel_bottom.h"

#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "scene/scene_same.h"

void rmap_bottoms_release(struct rmap_accel *accel)
{
    for (size_t i = 0; accel->bottom && i < accel->n_bottom; i++)
        rmap_bottom_release(accel->bottom[i]);
    rmap_free(accel->bottom);
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
        RMAP_TRY(rmap_bottom_create(accel, geometry, &accel->bottom[i], err));
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
