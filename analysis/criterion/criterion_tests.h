/* SPDX-License-Identifier: MIT
 *
 * What a test counts, as bits: a bit per row of a table, or per ray.
 */
#ifndef RMAP_CRITERION_TESTS_H
#define RMAP_CRITERION_TESTS_H

#include "analysis/criterion/criterion_evaluate.h"

struct rmap_evaluation {
    const struct rmap_criterion *criterion;
    const struct rmap_criterion_input *input;
    const struct rmap_portion *portion; /* of the input */
    struct rmap_evaluator *evaluator;
    size_t n_ray;
    uint32_t *count; /* [n_ray] of the evaluator */
};

enum rmap_status rmap_evaluation_fetch(const struct rmap_evaluation *ev, rmap_column_set columns,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* How many rows each ray has in a table: (*n_rows_ret)[n_ray], which add up to those that are
 * there, or RMAP_FORMAT. */
enum rmap_status rmap_test_count_rows(const struct rmap_evaluation *ev, enum rmap_table table,
                                      const uint32_t **n_rows_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* What a test marks; valid until the next. index: of the node, which may stand looser here. surely:
 * of registrations, marks->sure is asked for. */
enum rmap_status rmap_test_mark(const struct rmap_evaluation *ev, int32_t index,
                                const struct rmap_criterion_node *node, bool surely,
                                struct rmap_marks *marks, struct rmap_error *err) RMAP_MUST_USE;

/* Marks of each ray, as struct rmap_marks has them: count [n_ray]. */
void rmap_test_count(const uint64_t *bits, const uint32_t *n_rows, size_t n_ray, uint32_t *count);

#endif
