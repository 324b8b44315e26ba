/* SPDX-License-Identifier: MIT
 *
 * The rows of a block's parts, from when they are recorded to when the block is appended: kept past
 * the caches, which they would take from the scene.
 */
#ifndef RMAP_ROW_PARTS_H
#define RMAP_ROW_PARTS_H

#include "compact/layout.h"

struct rmap_row_parts;

enum rmap_status rmap_row_parts_create(enum rmap_colour_mode mode,
                                       struct rmap_row_parts **parts_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;
void rmap_row_parts_destroy(struct rmap_row_parts *parts);

/* Forgets the parts and keeps their memory. */
void rmap_row_parts_clear(struct rmap_row_parts *parts);

/* Copies a part that has all columns. RMAP_SYSTEM when memory is short: the parts stand. */
enum rmap_status rmap_row_parts_add(struct rmap_row_parts *parts, const struct rmap_portion *part,
                                    struct rmap_error *err) RMAP_MUST_USE;

size_t rmap_row_parts_count(const struct rmap_row_parts *parts);

/* Rows of part i in the plain encoding, borrowed until clear. */
void rmap_row_parts_rows(const struct rmap_row_parts *parts, size_t i, struct rmap_rows *rows);

#endif
