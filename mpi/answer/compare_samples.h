/* SPDX-License-Identifier: MIT
 *
 * The samples of a comparison: two; or, of one map, what criterion A has alone, what B has alone,
 * and what both have.
 */
#ifndef RMAP_COMPARE_SAMPLES_H
#define RMAP_COMPARE_SAMPLES_H

#include "analysis/query/fold.h"
#include "mpi/command/command.h"

enum { RMAP_COMPARE_SAMPLES = 3, RMAP_COMPARE_PARTS = 5 };

/* Rays, and registrations of theirs, that belong to one sample. */
struct rmap_compare_part {
    const struct rmap_criterion *criterion;
    const struct rmap_which *which;
    size_t sample;
    bool registrations_alone; /* the rays themselves are another sample's */
};

/* All borrowed. */
struct rmap_compare_samples {
    const struct rmap_map *map[2];         /* the same one twice where two criteria are compared */
    const struct rmap_overlay *overlay[2]; /* NULL: no receivers */
    size_t n;                              /* 2 or 3 */
    struct rmap_compare_part part[RMAP_COMPARE_PARTS];
    size_t n_part;
};

/* Which map a sample is of. */
static inline int rmap_compare_map_of(const struct rmap_compare_samples *samples, size_t sample)
{
    return samples->n > 2 ? 0 : (int)sample;
}

/* Sums over the samples. context: of each map; alone: of parts that bring registrations alone; NULL
 * where no registrations are summed. */
struct rmap_compare_sum {
    const struct rmap_fold_kind *kind;
    const void *context[2];
    const void *alone;
    rmap_column_set columns[2];
    size_t n_sample; /* the first so many */
};

/* Collective. state: on rank 0 of each sample (kind->destroy, also when it fails), NULL at first.
 */
enum rmap_status rmap_compare_samples_run(const struct rmap_context *context,
                                          const struct rmap_compare_samples *samples,
                                          const struct rmap_compare_sum *sum, void **state,
                                          struct rmap_error *err) RMAP_MUST_USE;

#endif
