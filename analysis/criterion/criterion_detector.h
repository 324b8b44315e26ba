/* SPDX-License-Identifier: MIT
 *
 * Tests of a ray's registrations: registered, crossed, angle, x, y, time, optical_path, where.
 */
#ifndef RMAP_CRITERION_DETECTOR_H
#define RMAP_CRITERION_DETECTOR_H

#include "analysis/criterion/criterion_mark.h"
#include "analysis/criterion/criterion_parser.h"

/* angle(detector) < ... and its like: any registration there satisfies the comparison. */
enum rmap_status rmap_parse_any_number(struct rmap_parser *parser,
                                       struct rmap_criterion_node *node) RMAP_MUST_USE;

/* Of which dimension a number of a registration is on these detectors. */
enum rmap_dimension rmap_its_number_dimension(const struct rmap_scene *scene,
                                              enum rmap_registration_number number,
                                              const struct rmap_index_set *detector);

/* One comparison inside `where`. */
enum rmap_status rmap_parse_where_test(struct rmap_parser *parser, int32_t *node_ret) RMAP_MUST_USE;

enum rmap_status rmap_parse_registered(struct rmap_parser *parser,
                                       struct rmap_criterion_node *node) RMAP_MUST_USE;

enum rmap_status rmap_parse_detected(struct rmap_parser *parser,
                                     struct rmap_criterion_node *node) RMAP_MUST_USE;

enum rmap_status rmap_parse_crossed(struct rmap_parser *parser,
                                    struct rmap_criterion_node *node) RMAP_MUST_USE;

enum rmap_status rmap_parse_which(struct rmap_parser *parser, const struct rmap_index_set *detector,
                                  struct rmap_criterion_node *node) RMAP_MUST_USE;

#endif
