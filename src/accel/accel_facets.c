/* SPDX-License-Identifier: MIT
 *
 * The triangles around each vertex of a mesh. Vertices at the same place are one, whether or not
 * the file shared them.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "accel/accel_internal.h"
#include "base/alloc.h"

/* A ray begins this share of the float error that it may be off behind its start: see
 * RMAP_REACH_ERRORS. */
#define LEAST_COSINE (4.0 / RMAP_REACH_ERRORS)

struct placed {
    float at[3];
    uint32_t vertex;
};

static int compare(const void *left, const void *right)
{
    const struct placed *a = left, *b = right;
    for (int k = 0; k < 3; k++)
        if (a->at[k] != b->at[k])
            return a->at[k] < b->at[k] ? -1 : 1;
    return a->vertex < b->vertex ? -1 : a->vertex > b->vertex;
}

static bool same_place(const struct placed *a, const struct placed *b)
{
    return a->at[0] == b->at[0] && a->at[1] == b->at[1] && a->at[2] == b->at[2];
}

static bool join_vertices(const struct rmap_mesh *mesh, uint32_t *same)
{
    struct placed *sorted = rmap_alloc(mesh->n_vertex, sizeof(*sorted));
    if (!sorted)
        return false;
    for (size_t i = 0; i < mesh->n_vertex; i++) {
        memcpy(sorted[i].at, mesh->vertex[i], sizeof(sorted[i].at));
        sorted[i].vertex = (uint32_t)i;
    }
    qsort(sorted, mesh->n_vertex, sizeof(*sorted), compare);
    size_t leader = 0;
    for (size_t i = 0; i < mesh->n_vertex; i++) {
        if (!same_place(&sorted[leader], &sorted[i]))
            leader = i;
        same[sorted[i].vertex] = sorted[leader].vertex;
    }
    rmap_free(sorted);
    return true;
}

/* At RMAP_NEEDLE_SINE a triangle is not wide enough to be safe from any side. */
static void set_sight(const struct rmap_facets *facets, size_t i, double wider, float sight[4])
{
    struct rmap_vec3 corner[3];
    rmap_facets_corners(facets, (int32_t)i, corner);
    struct rmap_vec3 e1 = rmap_sub(corner[1], corner[0]), e2 = rmap_sub(corner[2], corner[0]);
    struct rmap_vec3 e0 = rmap_sub(e2, e1), n = rmap_cross(e1, e2);
    double area = rmap_length(n), cosine = HUGE_VAL;
    double longest = rmap_max(rmap_dot(e0, e0), rmap_max(rmap_dot(e1, e1), rmap_dot(e2, e2)));
    if (area > RMAP_NEEDLE_SINE * longest) {
        cosine = rmap_max(wider / rmap_facet_margin(e1, e2, wider), LEAST_COSINE) * (1 + 1e-5);
        n = rmap_scale(n, 1 / area);
    }
    sight[0] = (float)n.x;
    sight[1] = (float)n.y;
    sight[2] = (float)n.z;
    sight[3] = (float)cosine;
}

enum rmap_status rmap_facets_build(const struct rmap_mesh *mesh, double wider,
                                   struct rmap_facets *facets, struct rmap_error *err)
{
    facets->same = rmap_alloc(mesh->n_vertex, sizeof(*facets->same));
    facets->first = rmap_alloc(mesh->n_vertex + 2, sizeof(*facets->first));
    facets->fan = rmap_alloc(3 * mesh->n_triangle, sizeof(*facets->fan));
    facets->corner = rmap_alloc(mesh->n_triangle, sizeof(*facets->corner));
    facets->sight = rmap_alloc(mesh->n_triangle, sizeof(*facets->sight));
    if (!facets->corner || !facets->sight || !facets->same || !facets->first || !facets->fan ||
        !join_vertices(mesh, facets->same)) {
        rmap_facets_release(facets);
        return rmap_error_set(err, RMAP_SYSTEM, "no memory for a mesh of %zu triangles",
                              mesh->n_triangle);
    }
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

void rmap_facets_release(struct rmap_facets *facets)
{
    rmap_free(facets->corner);
    rmap_free(facets->sight);
    rmap_free(facets->same);
    rmap_free(facets->first);
    rmap_free(facets->fan);
    memset(facets, 0, sizeof(*facets));
}
