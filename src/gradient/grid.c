/* SPDX-License-Identifier: MIT
 *
 * Numbers on a regular grid of three axes, shared by those who hold them.
 */
#include "gradient/grid.h"

#include "base/alloc.h"

enum rmap_status rmap_grid_create(const size_t n[3], struct rmap_vec3 origin,
                                  struct rmap_vec3 spacing, struct rmap_grid **grid_ret,
                                  struct rmap_error *err)
{
    size_t count = 1;
    for (int axis = 0; axis < 3; axis++) {
        if (n[axis] < 2)
            return rmap_error_set(err, RMAP_INPUT,
                                  "a grid has %zu node%s along %c: it needs 2 at least", n[axis],
                                  n[axis] == 1 ? "" : "s", "xyz"[axis]);
        if (n[axis] > RMAP_GRID_NUMBER_MAX / count)
            return rmap_error_set(err, RMAP_INPUT,
                                  "a grid of %zu x %zu x %zu nodes is too large: %zu at most", n[0],
                                  n[1], n[2], RMAP_GRID_NUMBER_MAX);
        count *= n[axis];
    }
    if (!(spacing.x > 0 && spacing.y > 0 && spacing.z > 0) ||
        !isfinite(rmap_dot(spacing, spacing)) || !isfinite(rmap_dot(origin, origin)))
        return rmap_error_set(
            err, RMAP_INPUT,
            "a grid's spacing (%g, %g, %g) and origin must be finite, the spacing "
            "greater than 0",
            spacing.x, spacing.y, spacing.z);
    struct rmap_grid *grid = rmap_alloc(1, sizeof *grid);
    double *value = grid ? rmap_alloc(count, sizeof *value) : NULL;
    if (!value) {
        rmap_free(grid);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a grid of %zu numbers", count);
    }
    *grid = (struct rmap_grid){{n[0], n[1], n[2]}, origin, spacing, value, 1};
    *grid_ret = grid;
    return RMAP_OK;
}

struct rmap_grid *rmap_grid_hold(struct rmap_grid *grid)
{
    grid->n_holder++;
    return grid;
}

void rmap_grid_drop(struct rmap_grid *grid)
{
    if (!grid || --grid->n_holder > 0)
        return;
    rmap_free(grid->value);
    rmap_free(grid);
}
