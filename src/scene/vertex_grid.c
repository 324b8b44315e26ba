/* SPDX-License-Identifier: MIT
 *
 * Sums and products are rounded monotonically: that of a box's corner is at least those of the
 * vertices in the box, as they are computed, and a cell whose corner does not reach farther than a
 * vertex that was seen holds none that does.
 */
#include "scene/vertex_grid.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"

enum { SIDE = 5, N_CELL = SIDE * SIDE * SIDE };

struct rmap_vertex_grid {
    float (*vertex)[3];
    size_t n_cell;                     /* those without vertices are left out */
    size_t first[N_CELL], end[N_CELL]; /* of a cell's vertices */
    float box[2][3][N_CELL];           /* about them: the least, the greatest of x, y, z */
};

static size_t cell_of(const float *v, const double lower[3], const double per_cell[3])
{
    size_t cell = 0;
    for (int k = 0; k < 3; k++) {
        const double place = ((double)v[k] - lower[k]) * per_cell[k];
        cell = SIDE * cell + (place > 0 ? (size_t)fmin(place, SIDE - 1) : 0);
    }
    return cell;
}

static void keep_cell(struct rmap_vertex_grid *grid, size_t cell, float (*vertex)[3])
{
    const size_t own = grid->n_cell++;
    grid->first[own] = grid->first[cell];
    grid->end[own] = grid->end[cell];
    for (int k = 0; k < 3; k++) {
        float low = HUGE_VALF, high = -HUGE_VALF;
        for (size_t i = grid->first[own]; i < grid->end[own]; i++) {
            low = fminf(low, vertex[i][k]);
            high = fmaxf(high, vertex[i][k]);
        }
        grid->box[0][k][own] = low;
        grid->box[1][k][own] = high;
    }
}

struct rmap_vertex_grid *rmap_vertex_grid_create(const struct rmap_mesh *mesh)
{
    struct rmap_bounds box = rmap_bounds_empty();
    struct rmap_vertex_grid *grid = rmap_alloc(1, sizeof *grid);
    float(*vertex)[3] = rmap_alloc_unset(mesh->n_vertex, sizeof *vertex);
    uint8_t *cell = rmap_alloc_unset(mesh->n_vertex, 1);
    if (!grid || !vertex || !cell) {
        rmap_free(grid);
        rmap_free(vertex);
        rmap_free(cell);
        return NULL;
    }
    for (size_t i = 0; i < mesh->n_vertex; i++) {
        const float *v = mesh->vertex[i];
        rmap_bounds_include(&box, rmap_vec3((double)v[0], (double)v[1], (double)v[2]));
    }
    const double lower[3] = {box.lower.x, box.lower.y, box.lower.z},
                 per_cell[3] = {SIDE / (box.upper.x - box.lower.x),
                                SIDE / (box.upper.y - box.lower.y),
                                SIDE / (box.upper.z - box.lower.z)};
    for (size_t i = 0; i < mesh->n_vertex; i++)
        grid->end[cell[i] = (uint8_t)cell_of(mesh->vertex[i], lower, per_cell)]++;
    for (size_t c = 0, n = 0; c < N_CELL; c++) {
        grid->first[c] = n;
        n += grid->end[c];
        grid->end[c] = grid->first[c];
    }
    for (size_t i = 0; i < mesh->n_vertex; i++)
        memcpy(vertex[grid->end[cell[i]]++], mesh->vertex[i], sizeof *vertex);
    for (size_t c = 0; c < N_CELL; c++)
        if (grid->end[c] > grid->first[c])
            keep_cell(grid, c, vertex);
    grid->vertex = vertex;
    rmap_free(cell);
    return grid;
}

void rmap_vertex_grid_destroy(struct rmap_vertex_grid *grid)
{
    if (grid)
        rmap_free(grid->vertex);
    rmap_free(grid);
}

/* As rmap_affine_point has it. */
static inline double along(const double m[3], double shift, float x, float y, float z)
{
    return m[0] * (double)x + m[1] * (double)y + m[2] * (double)z + shift;
}

static double farthest_in(const struct rmap_vertex_grid *grid, size_t cell, const double m[3],
                          double shift, double far)
{
    for (size_t i = grid->first[cell]; i < grid->end[cell]; i++) {
        const float *v = grid->vertex[i];
        const double p = along(m, shift, v[0], v[1], v[2]);
        far = p > far ? p : far;
    }
    return far;
}

/* The greatest of m . vertex + shift. */
static double farthest(const struct rmap_vertex_grid *grid, const double m[3], double shift)
{
    const float *x = grid->box[m[0] > 0][0], *y = grid->box[m[1] > 0][1],
                *z = grid->box[m[2] > 0][2];
    double corner[N_CELL], most = -HUGE_VAL;
    size_t best = 0;
    for (size_t c = 0; c < grid->n_cell; c++)
        corner[c] = along(m, shift, x[c], y[c], z[c]);
    for (size_t c = 0; c < grid->n_cell; c++)
        if (corner[c] > most) {
            most = corner[c];
            best = c;
        }
    double far = farthest_in(grid, best, m, shift, -HUGE_VAL);
    for (size_t c = 0; c < grid->n_cell; c++)
        if (corner[c] > far)
            far = farthest_in(grid, c, m, shift, far);
    return far;
}

/* Nothing becomes infinite: vertices are floats. */
static bool is_moderate(double number)
{
    return fabs(number) < 1e150;
}

bool rmap_vertex_grid_bounds(const struct rmap_vertex_grid *grid,
                             const struct rmap_affine *to_world, struct rmap_bounds *bounds_ret)
{
    const double shift[3] = {to_world->t.x, to_world->t.y, to_world->t.z};
    double lower[3], upper[3];
    for (int k = 0; k < 3; k++) {
        const double *m = to_world->m[k], back[3] = {-m[0], -m[1], -m[2]};
        if (!is_moderate(m[0]) || !is_moderate(m[1]) || !is_moderate(m[2]) ||
            !is_moderate(shift[k]))
            return false;
        upper[k] = farthest(grid, m, shift[k]);
        lower[k] = 0.0 - farthest(grid, back, -shift[k]);
    }
    *bounds_ret = (struct rmap_bounds){rmap_vec3(lower[0], lower[1], lower[2]),
                                       rmap_vec3(upper[0], upper[1], upper[2]), false};
    return true;
}
