/* SPDX-License-Identifier: MIT
 *
 * Values in a criterion: numbers with units, comparisons, ranges, regions.
 */
#ifndef RMAP_CRITERION_VALUE_H
#define RMAP_CRITERION_VALUE_H

#include "analysis/criterion/criterion_parser.h"

bool rmap_parser_at_comparison(const struct rmap_parser *parser);

/* Size of the unit in which a map has numbers of this dimension: in m, degrees, s, W or lm. */
double rmap_unit_size_of(const struct rmap_scene *scene, enum rmap_dimension dimension);

/* Whether numbers of the dimension may be in the unit; names of all that may, or why there are
 * none.
 */
#define RMAP_UNITS_NBYTES 64
bool rmap_unit_fits(const struct rmap_written_unit *unit, enum rmap_dimension dimension,
                    const struct rmap_scene *scene);
void rmap_unit_list(enum rmap_dimension dimension, const struct rmap_scene *scene,
                    char list[RMAP_UNITS_NBYTES]);

/* `a..b`, a unit behind b meant for both where a has none. own: size of the unit that the interval
 * is in, and bare numbers are. */
enum rmap_status rmap_parse_range(struct rmap_parser *parser, enum rmap_dimension dimension,
                                  double own, struct rmap_interval *interval) RMAP_MUST_USE;

/* Comparison with a value, or `in` with a range. */
enum rmap_status rmap_parse_interval(struct rmap_parser *parser, enum rmap_dimension dimension,
                                     struct rmap_interval *interval) RMAP_MUST_USE;

/* A value with or without a unit, in the map's unit of the dimension. */
enum rmap_status rmap_parse_value(struct rmap_parser *parser, enum rmap_dimension dimension,
                                  double *value_ret) RMAP_MUST_USE;

/* N or N..M, whole numbers from 0. */
enum rmap_status rmap_parse_index_range(struct rmap_parser *parser, uint32_t *low,
                                        uint32_t *high) RMAP_MUST_USE;

/* rect(...), ellipse(...), polygon(...), cells(...); the word is the next token. */
bool rmap_parser_at_region(const struct rmap_parser *parser);
enum rmap_status rmap_parse_region(struct rmap_parser *parser,
                                   struct rmap_registration_test *test) RMAP_MUST_USE;

/* A condition that is one range of x or of y alone becomes ranges of stored values, too. */
enum rmap_status rmap_parser_box_place(struct rmap_parser *parser,
                                       struct rmap_registration_test *test) RMAP_MUST_USE;

/* What positions on these detectors are measured in. */
enum rmap_dimension rmap_detector_dimension(const struct rmap_scene *scene,
                                            const struct rmap_index_set *detector);

#endif
