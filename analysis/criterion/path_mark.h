/* SPDX-License-Identifier: MIT
 *
 * Histories through an automaton. Rows become symbols by small tables, column by column; then a
 * step is one look-up. Several rays run at once, as each waits for its own look-up; a ray's end is
 * a symbol too, so that no branch depends on what the rays did.
 */
#ifndef RMAP_PATH_MARK_H
#define RMAP_PATH_MARK_H

#include "analysis/criterion/criterion_tree.h"

/* Rays' symbols are copied so many at a time, a little beyond their end. */
enum { RMAP_PATH_COPY = 8 };

/* Whether the histories are a PATH node's, to which its comparison is not put: match[i] = 1 or 0
 * for row i of /ray. Discrete columns alone decide it (node->path.columns), so that it may run on a
 * dictionary of histories. step: symbols of the rows of /segment, then room for RMAP_PATH_COPY,
 * where they are known, and its columns are not looked at; or NULL. RMAP_FORMAT when the rows do
 * not add up, RMAP_SYSTEM. Thread-safe. */
enum rmap_status rmap_path_mark(const struct rmap_criterion_node *node,
                                const struct rmap_portion *portion, const uint16_t *step,
                                uint8_t *match, struct rmap_error *err) RMAP_MUST_USE;

#endif
