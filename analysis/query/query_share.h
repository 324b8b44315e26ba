/* SPDX-License-Identifier: MIT
 *
 * Tests that stand in a scan's criteria more than once, word for word or not: evaluated once.
 */
#ifndef RMAP_QUERY_SHARE_H
#define RMAP_QUERY_SHARE_H

#include "analysis/criterion/criterion_tree.h"

struct rmap_shared_tests {
    size_t n_criterion;
    int32_t **slot; /* [n_criterion][its nodes] equal subtrees have the same, from 0; -1: none */
    size_t n_slot;
};

/* Equal: of the same 128-bit hash. RMAP_SYSTEM. */
enum rmap_status rmap_shared_tests_init(struct rmap_shared_tests *shared,
                                        const struct rmap_criterion *const *criterion,
                                        size_t n_criterion, struct rmap_error *err) RMAP_MUST_USE;
void rmap_shared_tests_fini(struct rmap_shared_tests *shared);

#endif
