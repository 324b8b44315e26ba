/* SPDX-License-Identifier: MIT
 *
 * Tests of single steps put to their classes, once for each piece.
 */
#ifndef RMAP_CLASS_TESTS_H
#define RMAP_CLASS_TESTS_H

#include "analysis/criterion/criterion_evaluate.h"
#include "compact/step_classes.h"
#include "io/map/map_cursor.h"

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

/* A bit for each of n steps (all of `steps`; classes that are not in hand may be among them) that
 * passes a test (RMAP_CRITERION_STEPS) of criterion c: bits [words of n, and one more]. index: of
 * the node. */
enum rmap_status rmap_class_tests_mark(struct rmap_class_tests *tests, size_t c, int32_t index,
                                       const struct rmap_criterion_node *node,
                                       const struct rmap_own_steps *steps, size_t n, uint64_t *bits,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* The symbols that a path (RMAP_CRITERION_PATH) has for them: symbol [n]. */
enum rmap_status rmap_class_tests_symbols(struct rmap_class_tests *tests, size_t c, int32_t index,
                                          const struct rmap_criterion_node *node,
                                          const struct rmap_own_steps *steps, size_t n,
                                          uint16_t *symbol, struct rmap_error *err) RMAP_MUST_USE;

#endif
