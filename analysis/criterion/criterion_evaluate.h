/* SPDX-License-Identifier: MIT
 *
 * Evaluation of a criterion on rays of which not everything need be known: columns are fetched
 * when a test first asks for them, and what may not be fetched leaves an outcome open.
 */
#ifndef RMAP_CRITERION_EVALUATE_H
#define RMAP_CRITERION_EVALUATE_H

#include "analysis/criterion/criterion_tree.h"

/* Bit 0: the ray may match; bit 1: it does. `and` is &, `or` is |. */
enum rmap_outcome { RMAP_OUTCOME_NO = 0, RMAP_OUTCOME_OPEN = 1, RMAP_OUTCOME_YES = 3 };

static inline uint8_t rmap_outcome_not(uint8_t outcome)
{
    return (uint8_t)((outcome & 1) << 1 | outcome >> 1) ^ RMAP_OUTCOME_YES;
}

/* Whether an interval holds a number that lies between these; they may be NaN. */
static inline uint8_t rmap_bounds_outcome(const struct rmap_interval *interval, double low,
                                          double high)
{
    const uint8_t inside = interval->outside ? RMAP_OUTCOME_NO : RMAP_OUTCOME_YES;
    if (low >= interval->low && high <= interval->high)
        return inside;
    return low > interval->high || high < interval->low ? rmap_outcome_not(inside)
                                                        : RMAP_OUTCOME_OPEN;
}

/* What a test counts: a bit per row, of which each ray has so many; or a bit per ray. */
struct rmap_marks {
    const uint64_t *bits;   /* borrowed; one word more may be read */
    const uint32_t *n_rows; /* [n_ray]; NULL: per ray */
    const uint64_t *sure;   /* of the bits, where these may count, those that do; NULL: none */
};

/* Rays, and how to learn about them. */
struct rmap_criterion_input {
    const struct rmap_portion *portion; /* its rays are counted; columns, and rows of the other
                                           tables, as far as fetched */
    rmap_column_set columns;            /* that may be fetched */
    bool is_rest; /* discrete columns left the rays of interest open: what only they decide, and is
                     joined to the rest by one `and` or `or`, need not be asked again. Outcomes of
                     other rays mean nothing */
    bool counts_exactly; /* a ray stays open while one of its rows does, though the others decide
                            it: who asks which rows count has it traced again anyway */
    const double *flux_per_weight;      /* [n_source]; NULL: `flux` may not be fetched */
    const struct rmap_path_sum *bounds; /* [n_ray] of numbers that may not be fetched; or NULL */
    void *context;
    /* Makes the portion have these columns, too. NULL: it has all that may be fetched. */
    enum rmap_status (*fetch)(void *context, rmap_column_set columns, struct rmap_error *err);
    /* What a test of discrete columns marks, found otherwise; bits NULL: look at the columns.
     * Valid until the next. index: of a node, whose test may stand looser in `node`. NULL: always
     * the columns. */
    enum rmap_status (*mark)(void *context, int32_t index, const struct rmap_criterion_node *node,
                             struct rmap_marks *marks, struct rmap_error *err);
};

/* Memory of an evaluation, to be used again. All zero at first. */
struct rmap_evaluator {
    uint32_t *count, *least; /* [n_ray] */
    uint8_t *mask;           /* [n_mask][n_ray] */
    size_t count_cap, least_cap, mask_cap;
    uint64_t *mark, *sure, *last; /* bits: of rows or rays; of rows; of rays */
    size_t mark_cap, sure_cap, last_cap;
};
void rmap_evaluator_fini(struct rmap_evaluator *evaluator);

/* What the criterion, one test that can be counted, counts per ray: count [n_ray]. The portion has
 * the criterion's columns. RMAP_FORMAT when its rows do not add up. */
enum rmap_status rmap_criterion_count(const struct rmap_criterion *criterion,
                                      const struct rmap_portion *portion, uint32_t *count,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* outcome: [n_ray], enum rmap_outcome; none is open when all the criterion's columns may be
 * fetched. Stops as soon as every ray is decided. */
enum rmap_status rmap_criterion_decide(const struct rmap_criterion *criterion,
                                       const struct rmap_criterion_input *input,
                                       struct rmap_evaluator *evaluator, uint8_t *outcome,
                                       struct rmap_error *err) RMAP_MUST_USE;

#endif
