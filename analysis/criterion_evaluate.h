/* SPDX-License-Identifier: MIT
 *
 * Evaluation of a criterion on rays of which not everything need be known: columns are fetched
 * when a test first asks for them, and what may not be fetched leaves a verdict open.
 */
#ifndef RMAP_CRITERION_EVALUATE_H
#define RMAP_CRITERION_EVALUATE_H

#include "analysis/criterion_tree.h"

/* Bit 0: the ray may match; bit 1: it does. `and` is &, `or` is |. */
enum rmap_verdict { RMAP_VERDICT_NO = 0, RMAP_VERDICT_OPEN = 1, RMAP_VERDICT_YES = 3 };

/* Rays, and how to learn about them. */
struct rmap_evidence {
    const struct rmap_portion *portion; /* its rows are counted; columns as far as fetched */
    rmap_column_set columns;            /* that may be fetched */
    const double *flux_per_weight;      /* [n_source] */
    void *context;
    /* Makes the portion have these columns, too. NULL: it has all that may be fetched. */
    enum rmap_status (*fetch)(void *context, rmap_column_set columns, struct rmap_error *err);
    /* Rows per ray that a test of discrete columns counts, without these columns: count [n_ray].
     * NULL: from the columns. */
    enum rmap_status (*count_steps)(void *context, const struct rmap_step_test *test,
                                    uint32_t *count, struct rmap_error *err);
};

/* Memory of an evaluation, to be used again. All zero at first. */
struct rmap_judge {
    uint32_t *count; /* [n_ray] */
    uint8_t *mask;   /* [n_mask][n_ray] */
    size_t count_cap, mask_cap;
};
void rmap_judge_fini(struct rmap_judge *judge);

/* verdict: [n_ray], enum rmap_verdict; none is open when all the criterion's columns may be
 * fetched. Stops as soon as every ray is decided. */
enum rmap_status rmap_criterion_judge(const struct rmap_criterion *criterion,
                                      const struct rmap_evidence *evidence,
                                      struct rmap_judge *judge, uint8_t *verdict,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
