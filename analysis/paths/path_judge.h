/* SPDX-License-Identifier: MIT
 *
 * A criterion that is one path("...") alone, put to rays of a portion whose legs are steps already
 * (path_hash.h): steps become its symbols, so that columns need not be looked at again; rays whose
 * classes are known to match are left out.
 */
#ifndef RMAP_PATH_JUDGE_H
#define RMAP_PATH_JUDGE_H

#include "analysis/paths/path_hash.h"

/* Whether steps decide it: they tell objects and events apart as paths do. */
bool rmap_path_judges(const struct rmap_path_keys *keys, const struct rmap_criterion *criterion);

/* One thread's; all zero at first. */
struct rmap_path_judge {
    uint16_t *symbol; /* [2^16] of each step; NULL: not yet */
    uint8_t *match;   /* [n_ray] of the portion in hand */
    uint8_t *skip;    /* [n_ray] */
    size_t match_cap, skip_cap;
    size_t n_ray, n_match; /* of the portion before */
};
void rmap_path_judge_fini(struct rmap_path_judge *judge);

/* What is to be expected of the next portion, by the one before. */
static inline bool rmap_path_judge_expects_most(const struct rmap_path_judge *judge)
{
    return judge->n_match * 4 > judge->n_ray * 3;
}

static inline bool rmap_path_judge_expects_few(const struct rmap_path_judge *judge)
{
    return judge->n_match * 16 < judge->n_ray;
}

/* Of rays that are open: match and n_match; by columns, or by the steps of a hasher that has
 * entered them. RMAP_FORMAT when rows do not add up, RMAP_SYSTEM. */
enum rmap_status rmap_path_judge_columns(struct rmap_path_judge *judge, struct rmap_matched *rays,
                                         struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_path_judge_steps(struct rmap_path_judge *judge,
                                       const struct rmap_path_hasher *hasher,
                                       struct rmap_matched *rays,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* By steps, where all rays but those listed are known to match: left [*n_left] of them, ascending;
 * those that do not match are taken off the list, with what `with` has of them. */
enum rmap_status rmap_path_judge_left(struct rmap_path_judge *judge,
                                      const struct rmap_path_hasher *hasher,
                                      struct rmap_matched *rays, uint32_t *left, uint64_t *with,
                                      size_t *n_left, struct rmap_error *err) RMAP_MUST_USE;

#endif
