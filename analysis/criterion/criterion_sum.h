/* SPDX-License-Identifier: MIT
 *
 * Numbers compared with each other: x(film) > x(sensor), time(far) - 2 * time(near) < 1 ns; behind
 * `where` those of one registration, or of one step: x > y. Left minus right is a sum of numbers
 * times factors and a constant, which is compared with 0.
 */
#ifndef RMAP_CRITERION_SUM_H
#define RMAP_CRITERION_SUM_H

#include "analysis/criterion/criterion_parser.h"
#include "compact/path_sum.h"

/* Whether a comparison that begins at the next token has more in it than one number and a value. */
bool rmap_parser_at_sum(const struct rmap_parser *parser);

/* The comparison, of left minus right with 0; as a node. */
enum rmap_status rmap_parse_comparison(struct rmap_parser *parser, struct rmap_sum *sum,
                                       struct rmap_interval *interval) RMAP_MUST_USE;
enum rmap_status rmap_parse_sum(struct rmap_parser *parser, int32_t *node_ret) RMAP_MUST_USE;

/* A sum alone, as `stats --of` has it; its terms are the criterion's. */
enum rmap_status rmap_parse_sum_alone(struct rmap_parser *parser, struct rmap_sum *sum,
                                      enum rmap_dimension *dimension_ret) RMAP_MUST_USE;

/* Columns that a sum is made of. */
rmap_column_set rmap_sum_columns(const struct rmap_sum *sum);

/* Whether it holds for the numbers of ray i, whose rows of /registration are [first, first + n):
 * for any registration of each number's own. False where one of them has none. */
bool rmap_sum_holds_for_ray(const struct rmap_criterion *criterion,
                            const struct rmap_criterion_node *node,
                            const struct rmap_portion *portion, const double *flux_per_weight,
                            size_t i, size_t first, size_t n);

/* Numbers of rays of which a path tells the least and greatest; and where all of a sum are such,
 * what it lies between (NaN: not known). */
static inline bool rmap_number_is_bounded(enum rmap_ray_number number)
{
    return number == RMAP_RAY_NUMBER_PATH_LENGTH || number == RMAP_RAY_NUMBER_OPTICAL_PATH;
}
static inline void rmap_number_bound(enum rmap_ray_number number, const struct rmap_path_sum *of,
                                     double bound[2])
{
    const float *its = number == RMAP_RAY_NUMBER_PATH_LENGTH ? of->path_length : of->optical_path;
    bound[0] = (double)its[0];
    bound[1] = (double)its[1];
}
bool rmap_sum_is_bounded(const struct rmap_sum *sum);
void rmap_sum_bound(const struct rmap_sum *sum, const struct rmap_path_sum *of, double bound[2]);

/* The value of a sum alone. NaN, too, where registrations of a number in the rows differ in it. */
double rmap_sum_of_ray(const struct rmap_scene *scene, const struct rmap_sum *sum,
                       const struct rmap_portion *portion, const double *flux_per_weight, size_t i,
                       size_t first, size_t n);

/* The comparison for one registration, in row `row`. */
bool rmap_sum_holds_for_registration(const struct rmap_criterion *criterion,
                                     const struct rmap_criterion_node *node,
                                     const struct rmap_portion *portion, size_t row);

#endif
