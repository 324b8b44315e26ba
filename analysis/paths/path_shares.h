/* SPDX-License-Identifier: MIT
 *
 * How many of a portion's matching rays share each path, where the portion is summed up by its
 * paths.
 */
#ifndef RMAP_PATH_SHARES_H
#define RMAP_PATH_SHARES_H

#include "analysis/query/fold.h"

/* One thread's; all zero at first. */
struct rmap_path_shares {
    size_t n;        /* paths that matching rays took; of each: */
    uint32_t *row;   /* [n] row of told->paths */
    uint32_t *n_ray; /* [n] these rays */
    uint64_t *first; /* [n] the smallest id of them */

    uint32_t *number_of; /* [1 + row] 1 + number of a path in the portion in hand; 0: none */
    size_t row_cap, n_ray_cap, first_cap, number_cap;
    uint8_t *own; /* [n_own] of the others: 1 if it matches */
    size_t own_cap;
};
void rmap_path_shares_fini(struct rmap_path_shares *shares);

/* Whether to go by paths: the portion is summed up so; and where deciding which rays match took the
 * columns anyway, few rays have paths of their own, which would be decoded again. */
bool rmap_path_shares_matter(const struct rmap_matched *rays,
                             const struct rmap_path_summary *summary);

/* Counts rays that share paths; those with paths of their own are left out. */
enum rmap_status rmap_path_shares_count(struct rmap_path_shares *shares,
                                        const struct rmap_matched *rays,
                                        const struct rmap_path_summary *summary,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* The matching rays with paths of their own, as a portion of them; borrowed from shares and rays.
 * n_match 0: there are none, and no portion. */
enum rmap_status rmap_path_shares_own(struct rmap_path_shares *shares,
                                      const struct rmap_matched *rays,
                                      const struct rmap_path_summary *summary,
                                      struct rmap_matched *own,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
