/* SPDX-License-Identifier: MIT
 *
 * Memory for what stays of an open map between questions: many blocks of some kilobytes that all go
 * at once, within a budget of bytes.
 */
#ifndef RMAP_ARENA_H
#define RMAP_ARENA_H

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

struct rmap_arena;

enum rmap_status rmap_arena_create(size_t limit_nbytes, struct rmap_arena **arena_ret,
                                   struct rmap_error *err) RMAP_MUST_USE;
void rmap_arena_destroy(struct rmap_arena *arena); /* and all blocks */

/* A block, undefined inside, aligned to 64 bytes; NULL: the budget or the machine's memory does not
 * allow it. Thread-safe, as is all that follows. */
void *rmap_arena_room(struct rmap_arena *arena, size_t nbytes);

size_t rmap_arena_limit(const struct rmap_arena *arena);
size_t rmap_arena_nbytes(const struct rmap_arena *arena); /* taken; never above the limit */

#endif
