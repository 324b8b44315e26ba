/* SPDX-License-Identifier: MIT
 *
 * What rank 0 alone reads of a map in memory, whose portions stand on all ranks: those of others
 * are sent to it when it comes to them, one at a time. Maps on disk are read by whom it may be, and
 * nothing of this happens.
 */
#ifndef RMAP_HEAD_READS_H
#define RMAP_HEAD_READS_H

#include "io/map/map_reader.h"
#include "mpi/parallel/context.h"

struct rmap_head_reads;

/* Collective. Other ranks come back from it once rank 0 has come to the end; *reads_ret is NULL on
 * them, and where nothing is to be sent. map: borrowed until then. A portion stays until
 * the next one of other ranks is read. */
enum rmap_status rmap_head_reads_begin(const struct rmap_context *context,
                                       const struct rmap_map *map,
                                       struct rmap_head_reads **reads_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;
void rmap_head_reads_end(struct rmap_head_reads *reads); /* NULL is fine */

#endif
