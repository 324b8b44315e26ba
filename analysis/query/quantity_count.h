/* SPDX-License-Identifier: MIT
 *
 * A test of the criterion language as a number: how often it holds along a ray.
 */
#ifndef RMAP_QUANTITY_COUNT_H
#define RMAP_QUANTITY_COUNT_H

#include "analysis/criterion/criterion_parser.h"
#include "analysis/criterion/criterion_tree.h"

/* The parser at the first word, to its end. counts: what that word stands for ("registered(*)" for
 * "registrations"), or NULL, a word of the criteria. RMAP_INPUT for what is no count: logic, or a
 * comparison. *counted_ret: owned by the caller, also after a failure behind it. */
enum rmap_status rmap_quantity_parse_count(struct rmap_parser *parser,
                                           const struct rmap_scene *scene, const char *counts,
                                           struct rmap_criterion **counted_ret) RMAP_MUST_USE;

#endif
