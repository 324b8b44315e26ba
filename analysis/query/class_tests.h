/* SPDX-License-Identifier: MIT
 *
 * Tests of single steps and registrations put to their classes, once for each piece.
 */
#ifndef RMAP_CLASS_TESTS_H
#define RMAP_CLASS_TESTS_H

#include "analysis/criterion/criterion_evaluate.h"
#include "history/history_index.h"

struct rmap_class_tests;

/* The criteria are borrowed. One thread. */
enum rmap_status rmap_class_tests_create(const struct rmap_criterion *const *criterion,
                                         size_t n_criterion, struct rmap_class_tests **tests_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;
void rmap_class_tests_destroy(struct rmap_class_tests *tests); /* NULL is fine */

/* Takes the classes of a piece in hand, which must outlive that: step [n_step], hit [n_hit]. */
enum rmap_status rmap_class_tests_enter(struct rmap_class_tests *tests,
                                        const struct rmap_step_class *step, size_t n_step,
                                        const struct rmap_history_hit *hit, size_t n_hit,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* What a test of criterion c says of them: uint8_t [n_step], or [n_hit], 1 where it passes; of a
 * path uint16_t [n_step], the symbols. index: of the node. Borrowed until the next piece. */
enum rmap_status rmap_class_tests_answer(struct rmap_class_tests *tests, size_t c, int32_t index,
                                         const struct rmap_criterion_node *node,
                                         const void **of_class_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;

#endif
