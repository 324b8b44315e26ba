/* SPDX-License-Identifier: MIT
 *
 * Edges at which a mesh is open.
 */
#include "geometry/mesh_edges.h"

#include <stdlib.h>

#include "base/alloc.h"

static int compare_edges(const void *a, const void *b)
{
    const struct rmap_mesh_edge *x = a, *y = b;
    if (x->from != y->from)
        return x->from < y->from ? -1 : 1;
    return x->to < y->to ? -1 : x->to > y->to;
}

enum rmap_status rmap_mesh_open_edges(const struct rmap_mesh *mesh, size_t *n_ret,
                                      struct rmap_mesh_edge *first_ret, struct rmap_error *err)
{
    const size_t n = 3 * mesh->n_triangle;
    struct rmap_mesh_edge *edge = rmap_alloc(n + 1, sizeof *edge);
    *n_ret = 0;
    if (!edge)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu edges", n);
    for (size_t i = 0; i < n; i++) {
        const uint32_t *triangle = mesh->triangle[i / 3];
        const uint32_t a = triangle[i % 3], b = triangle[(i + 1) % 3];
        edge[i] = a < b ? (struct rmap_mesh_edge){a, b, 1} : (struct rmap_mesh_edge){b, a, -1};
    }
    qsort(edge, n, sizeof *edge, compare_edges);
    for (size_t i = 0, end; i < n; i = end) {
        int turn = 0;
        for (end = i; end < n && compare_edges(&edge[i], &edge[end]) == 0; end++)
            turn += edge[end].turn;
        if (turn != 0 && (*n_ret)++ == 0)
            *first_ret = edge[i];
    }
    rmap_free(edge);
    return RMAP_OK;
}
