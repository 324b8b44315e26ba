/* SPDX-License-Identifier: MIT
 *
 * Values in a criterion: numbers with units, comparisons, ranges, regions.
 */
#ifndef RMAP_CRITERION_VALUE_H
#define RMAP_CRITERION_VALUE_H

#include "analysis/criterion/criterion_parser.h"

bool rmap_parser_at_comparison(const struct rmap_parser *parser);

/* `a..b`, a unit behind b meant for both where a has none. */
enum rmap_status rmap_parse_range(struct rmap_parser *parser, enum rmap_dimension dimension,
                                  struct rmap_interval *interval) RMAP_MUST_USE;

/* Comparison with a value, or `in` with a range. */
enum rmap_status rmap_parse_interval(struct rmap_parser *parser, enum rmap_dimension dimension,
                                     struct rmap_interval *interval) RMAP_MUST_USE;

/* N or N..M, whole numbers from 0. */
enum rmap_status rmap_parse_index_range(struct rmap_parser *parser, uint32_t *low,
                                        uint32_t *high) RMAP_MUST_USE;

/* rect(...), ellipse(...), polygon(...), cells(...); the word is the next token. */
bool rmap_parser_at_region(const struct rmap_parser *parser);
enum rmap_status rmap_parse_region(struct rmap_parser *parser,
                                   struct rmap_registration_test *test) RMAP_MUST_USE;

/* What positions on these detectors are measured in. */
enum rmap_dimension rmap_detector_dimension(const struct rmap_scene *scene,
                                            const struct rmap_index_set *detector);

#endif
