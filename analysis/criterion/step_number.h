/* SPDX-License-Identifier: MIT
 *
 * Numbers of a step, by which a test chooses among the steps of its kind:
 * hit(lens.3, reflect where angle > 60).
 */
#ifndef RMAP_STEP_NUMBER_H
#define RMAP_STEP_NUMBER_H

#include "analysis/criterion/criterion_parser.h"
#include "analysis/criterion/criterion_tree.h"

/* A sum of numbers of the step, of one alone mostly, and what it must keep within. */
struct rmap_step_limit {
    struct rmap_sum sum;
    struct rmap_interval interval;
};

/* Whether a token is the word of a number; the next one, taken, with its unit. */
bool rmap_step_number_is(const struct rmap_parser *parser, const struct rmap_token *token);
enum rmap_status rmap_parse_step_number(struct rmap_parser *parser,
                                        enum rmap_step_number *number_ret,
                                        enum rmap_dimension *dimension_ret) RMAP_MUST_USE;

/* The end of a test of steps: `where NUMBER COMPARISON and ...`, if it is there, in addition to the
 * limits that the test has, and the parenthesis. what: else expected here. */
enum rmap_status rmap_parse_step_end(struct rmap_parser *parser, struct rmap_step_test *test,
                                     const char *what) RMAP_MUST_USE;

/* Words of the numbers: the i-th, NULL behind the last. */
const char *rmap_step_number_word(size_t i);

/* Columns that the limits of a test need. Of a test, those that discrete ones decide come first. */
rmap_column_set rmap_step_limit_columns(const struct rmap_step_test *test);

/* How many limits, from the first on, these columns decide. */
size_t rmap_step_limits_known(const struct rmap_step_limit *limit, size_t n,
                              rmap_column_set columns);

/* Whether a row of /segment, of the ray in row `ray` of /ray whose segments begin at `ray_row`,
 * keeps within all limits. What is not defined does not: an angle where nothing is met, angle and
 * lengths of curved legs, lengths of the way behind them, a wavelength where several are left, and
 * which of two models scattered at a gradient medium. */
bool rmap_step_limits_hold(const struct rmap_scene *scene, const struct rmap_step_test *test,
                           const struct rmap_portion *portion, size_t row, size_t ray,
                           size_t ray_row);

#endif
