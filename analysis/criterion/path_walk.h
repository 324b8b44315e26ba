/* SPDX-License-Identifier: MIT
 *
 * A path("...") put to the history up to a registration, from one registration of a ray to its
 * next.
 */
#ifndef RMAP_PATH_WALK_H
#define RMAP_PATH_WALK_H

#include "analysis/criterion/path_table.h"

struct rmap_path_walk {
    const struct rmap_path_table *table;
    size_t ray;                  /* row of /ray */
    size_t first_step;           /* its first row of /segment */
    size_t n_step;               /* rows of /segment that were taken */
    size_t next_hit;             /* row of /registration that has not been taken */
    uint32_t state, last_symbol; /* before the last symbol, which may be the history's last */
};

/* At the emission of a ray, a row of /ray, and where its rows of the other tables begin. */
struct rmap_path_walk rmap_path_walk_from(const struct rmap_path_table *table, size_t ray,
                                          size_t first_step, size_t first_hit);

/* Whether the history up to and with the ray's registration `hit` matches; not before one that was
 * walked to. A crossing that was not registered is no part of the history. The portion has the
 * columns of the test. */
bool rmap_path_walk_to(struct rmap_path_walk *walk, const struct rmap_portion *portion, size_t hit);

#endif
