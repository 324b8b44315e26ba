/* SPDX-License-Identifier: MIT
 *
 * Numbers on a regular grid of three axes, shared by those who hold them.
 */
#ifndef RMAP_GRID_H
#define RMAP_GRID_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "base/vec.h"

/* 2^31 numbers, 16 GiB. */
#define RMAP_GRID_NUMBER_MAX ((size_t)1 << 31)

struct rmap_grid {
    size_t n[3];                      /* nodes along x, y, z, each >= 2 */
    struct rmap_vec3 origin, spacing; /* of node (0, 0, 0); > 0; in the field's unit of length */
    double *value;                    /* [n[0]][n[1]][n[2]]; NaN: a hole */
    int n_holder;
};

/* Values 0, held once. RMAP_INPUT: too few nodes or too many, a spacing that is not > 0. */
enum rmap_status rmap_grid_create(const size_t n[3], struct rmap_vec3 origin,
                                  struct rmap_vec3 spacing, struct rmap_grid **grid_ret,
                                  struct rmap_error *err) RMAP_MUST_USE;
/* One more holder; not for threads at once. */
struct rmap_grid *rmap_grid_hold(struct rmap_grid *grid);
void rmap_grid_drop(struct rmap_grid *grid); /* the last holder frees it; NULL is fine */

static inline size_t rmap_grid_count(const struct rmap_grid *grid)
{
    return grid->n[0] * grid->n[1] * grid->n[2];
}

#endif
