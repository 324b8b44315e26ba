/* SPDX-License-Identifier: MIT
 *
 * Lines of a figure in view coordinates: where a plane cuts a mesh, chained into long runs.
 */
#include "analysis/figure/figure_outline.h"

#include <stdlib.h>

#include "base/alloc.h"

void rmap_outline_fini(struct rmap_outline *outline)
{
    rmap_free(outline->point);
    rmap_free(outline->run);
    *outline = (struct rmap_outline){0};
}

enum rmap_status rmap_outline_begin(struct rmap_outline *outline, struct rmap_error *err)
{
    enum rmap_status st = RMAP_RESERVE(outline->run, outline->run_cap, outline->n_run + 1, err);
    if (st == RMAP_OK)
        outline->run[outline->n_run++] = (struct rmap_outline_run){.first = outline->n_point};
    return st;
}

enum rmap_status rmap_outline_add(struct rmap_outline *outline, double u, double v,
                                  struct rmap_error *err)
{
    enum rmap_status st =
        RMAP_RESERVE(outline->point, outline->point_cap, outline->n_point + 1, err);
    if (st != RMAP_OK)
        return st;
    outline->point[outline->n_point][0] = u;
    outline->point[outline->n_point++][1] = v;
    outline->run[outline->n_run - 1].n++;
    return RMAP_OK;
}

/* Where the plane cuts one triangle: two points, each on an edge of the mesh. */
struct cut {
    double at[2][2];
    uint64_t edge[2];
    size_t link[2]; /* the end (2 cut + side) that shares the edge; NONE */
    bool used;
};

static const size_t NONE = (size_t)-1;

struct end {
    uint64_t edge;
    size_t end; /* 2 cut + side */
};

static int by_edge(const void *a, const void *b)
{
    const struct end *left = a, *right = b;
    if (left->edge != right->edge)
        return left->edge < right->edge ? -1 : 1;
    return (left->end > right->end) - (left->end < right->end);
}

/* Vertices on the plane count as above it: an edge is cut or not, never half. */
static size_t cut_triangles(const struct rmap_mesh *mesh, const struct rmap_vec3 *vertex,
                            struct cut *cut)
{
    size_t n = 0;
    for (size_t t = 0; t < mesh->n_triangle; t++) {
        int side = 0;
        for (int k = 0; k < 3; k++) {
            uint32_t a = mesh->triangle[t][k], b = mesh->triangle[t][(k + 1) % 3];
            if (a > b) {
                uint32_t swap = a;
                a = b;
                b = swap;
            }
            if ((vertex[a].z >= 0.0) == (vertex[b].z >= 0.0))
                continue;
            double s = vertex[a].z / (vertex[a].z - vertex[b].z);
            cut[n].at[side][0] = vertex[a].x + s * (vertex[b].x - vertex[a].x);
            cut[n].at[side][1] = vertex[a].y + s * (vertex[b].y - vertex[a].y);
            cut[n].edge[side++] = (uint64_t)a << 32 | b;
        }
        if (side == 2)
            cut[n++].used = false;
    }
    return n;
}

static void link_ends(struct cut *cut, size_t n, struct end *end)
{
    for (size_t i = 0; i < 2 * n; i++) {
        end[i] = (struct end){cut[i / 2].edge[i % 2], i};
        cut[i / 2].link[i % 2] = NONE;
    }
    qsort(end, 2 * n, sizeof *end, by_edge);
    for (size_t i = 0; i + 1 < 2 * n; i++) {
        size_t a = end[i].end, b = end[i + 1].end;
        if (end[i].edge != end[i + 1].edge)
            continue;
        cut[a / 2].link[a % 2] = b;
        cut[b / 2].link[b % 2] = a;
        i++;
    }
}

/* Follows the chain that begins at an end of a cut. */
static enum rmap_status follow(struct rmap_outline *outline, struct cut *cut, size_t start,
                               struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t at = start;
    RMAP_TRY(rmap_outline_begin(outline, err));
    RMAP_TRY(rmap_outline_add(outline, cut[at / 2].at[at % 2][0], cut[at / 2].at[at % 2][1], err));
    while (at != NONE && !cut[at / 2].used) {
        cut[at / 2].used = true;
        size_t far = at ^ 1;
        RMAP_TRY(rmap_outline_add(outline, cut[far / 2].at[far % 2][0], cut[far / 2].at[far % 2][1],
                                  err));
        at = cut[far / 2].link[far % 2];
    }
    outline->run[outline->n_run - 1].closed = at == start;
out:
    return st;
}

static enum rmap_status chain(struct rmap_outline *outline, struct cut *cut, size_t n,
                              struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct end *end = rmap_alloc(2 * n + 1, sizeof *end);
    if (!end)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a drawing");
    link_ends(cut, n, end);
    for (size_t i = 0; i < 2 * n; i++) /* open chains first, from their ends */
        if (!cut[i / 2].used && cut[i / 2].link[i % 2] == NONE)
            RMAP_TRY(follow(outline, cut, i, err));
    for (size_t i = 0; i < n; i++)
        if (!cut[i].used)
            RMAP_TRY(follow(outline, cut, 2 * i, err));
out:
    rmap_free(end);
    return st;
}

enum rmap_status rmap_outline_cut(struct rmap_outline *outline, const struct rmap_mesh *mesh,
                                  const struct rmap_affine *to_world, const struct rmap_view *view,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_vec3 *vertex = rmap_alloc(mesh->n_vertex + 1, sizeof *vertex);
    struct cut *cut = NULL;
    double low = INFINITY, high = -INFINITY, size = 0.0;
    if (!vertex)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a drawing");
    for (size_t i = 0; i < mesh->n_vertex; i++) {
        const float *v = mesh->vertex[i];
        vertex[i] = rmap_view_project(
            view, rmap_affine_point(to_world, rmap_vec3((double)v[0], (double)v[1], (double)v[2])));
        low = fmin(low, vertex[i].z);
        high = fmax(high, vertex[i].z);
        size = fmax(size, fabs(vertex[i].z));
    }
    for (size_t i = 0; i < mesh->n_vertex; i++) /* the noise of float vertices is on the plane */
        if (fabs(vertex[i].z) < 1e-6 * size)
            vertex[i].z = 0.0;
    if (!(low < 0.0 && high >= 0.0))
        goto out;
    cut = rmap_alloc(mesh->n_triangle + 1, sizeof *cut);
    if (!cut)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a drawing"));
    RMAP_TRY(chain(outline, cut, cut_triangles(mesh, vertex, cut), err));
out:
    rmap_free(vertex);
    rmap_free(cut);
    return st;
}

enum rmap_status rmap_outline_draw(const struct rmap_outline *outline, size_t first, size_t n_run,
                                   const struct rmap_view_frame *frame, struct rmap_svg *svg,
                                   const struct rmap_svg_style *style, struct rmap_error *err)
{
    size_t n = 0;
    for (size_t i = first; i < first + n_run; i++)
        n += outline->run[i].n + 1;
    double(*pixel)[2] = rmap_alloc(n + 1, sizeof *pixel);
    if (!pixel)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a drawing");
    n = 0;
    for (size_t i = first; i < first + n_run; i++) {
        const struct rmap_outline_run *run = &outline->run[i];
        for (size_t k = 0; k < run->n; k++)
            rmap_view_pixel(frame, outline->point[run->first + k], pixel[n++]);
        pixel[n][0] = pixel[n][1] = (double)NAN;
        n++;
    }
    rmap_svg_path(svg, (const double(*)[2])pixel, n, style);
    rmap_free(pixel);
    return RMAP_OK;
}
