/* SPDX-License-Identifier: MIT
 *
 * Memory for what stays of an open map between questions: many blocks of some kilobytes that all go
 * at once, within a budget of bytes.
 */
#ifndef RMAP_KEEPER_H
#define RMAP_KEEPER_H

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

struct rmap_keeper;

enum rmap_status rmap_keeper_create(size_t limit_nbytes, struct rmap_keeper **keeper_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;
void rmap_keeper_destroy(struct rmap_keeper *keeper); /* and all blocks */

/* A block, undefined inside, aligned to 64 bytes; NULL: the budget or the machine's memory does not
 * allow it. Thread-safe, as is all that follows. */
void *rmap_keeper_room(struct rmap_keeper *keeper, size_t nbytes);

/* Counts memory that is kept elsewhere; false, with nothing counted: it is beyond the budget. */
bool rmap_keeper_claim(struct rmap_keeper *keeper, size_t nbytes);

size_t rmap_keeper_limit(const struct rmap_keeper *keeper);
size_t rmap_keeper_nbytes(const struct rmap_keeper *keeper); /* taken; never above the limit */

#endif
