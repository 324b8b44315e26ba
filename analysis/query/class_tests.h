/* SPDX-License-Identifier: MIT
 *
 * Tests of single steps put to their classes, once for each piece.
 */
#ifndef RMAP_CLASS_TESTS_H
#define RMAP_CLASS_TESTS_H

#include "analysis/criterion/criterion_evaluate.h"
#include "compact/step_classes.h"

struct rmap_class_tests;

/* The criteria are borrowed. One thread. */
enum rmap_status rmap_class_tests_create(const struct rmap_criterion *const *criterion,
                                         size_t n_criterion, struct rmap_class_tests **tests_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;
void rmap_class_tests_destroy(struct rmap_class_tests *tests); /* NULL is fine */

/* Takes the classes of a piece in hand, which must outlive that: step [n_step]. */
enum rmap_status rmap_class_tests_enter(struct rmap_class_tests *tests,
                                        const struct rmap_step_class *step, size_t n_step,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* What a test of steps (RMAP_CRITERION_STEPS) of criterion c says of them: [n_step], 1 where it
 * passes. index: of the node. Borrowed until the next piece. */
enum rmap_status rmap_class_tests_answer(struct rmap_class_tests *tests, size_t c, int32_t index,
                                         const struct rmap_criterion_node *node,
                                         const uint8_t **pass_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;

#endif
