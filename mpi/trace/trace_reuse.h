/* SPDX-License-Identifier: MIT
 *
 * Rays of an older map that a later version of its scene has, too: taken over while a trace goes
 * on, block by block, in place of tracing them.
 */
#ifndef RMAP_TRACE_REUSE_H
#define RMAP_TRACE_REUSE_H

#include "io/map/map_reader.h"
#include "portion/portion_recorder.h"
#include "trace/tally.h"
#include "trace/touched.h"

/* What is taken from where; the same on every rank, and for any number of threads. */
struct rmap_reuse {
    const struct rmap_map *map; /* borrowed */
    struct rmap_touch touch;
    size_t *portion; /* [n] of the map, in one colour space, in the order of their rays */
    size_t n;
};

/* Of a map whose scene of that colour space is an older version of this one; both borrowed. Nothing
 * where touch.change.all says why. RMAP_SYSTEM when memory is short. All zero is nothing, too. */
enum rmap_status rmap_reuse_init(struct rmap_reuse *reuse, const struct rmap_map *map,
                                 int32_t space, const struct rmap_scene *scene,
                                 struct rmap_error *err) RMAP_MUST_USE;
void rmap_reuse_fini(struct rmap_reuse *reuse);

/* Which share of the rays must be traced anew, by some of the portions. RMAP_FORMAT as a cursor. */
enum rmap_status rmap_reuse_estimate(const struct rmap_reuse *reuse, double *share_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* One per thread; reuse is borrowed. */
struct rmap_reuse_reader;
enum rmap_status rmap_reuse_reader_create(const struct rmap_reuse *reuse,
                                          struct rmap_reuse_reader **reader_ret,
                                          struct rmap_error *err) RMAP_MUST_USE;
void rmap_reuse_reader_destroy(struct rmap_reuse_reader *reader);

/* How many rays from `id` on, before `end`, can be taken over: 0 where that one must be traced, of
 * which *way_ret, until the next call, says what is known. reader NULL: nothing is. RMAP_FORMAT:
 * the map is damaged. */
enum rmap_status rmap_reuse_ready(struct rmap_reuse_reader *reader, uint64_t id, uint64_t end,
                                  uint64_t *n_ret, struct rmap_known_way *way_ret,
                                  struct rmap_error *err) RMAP_MUST_USE;

/* So many that are, behind those that were recorded; into the tally, too (NULL: not). */
enum rmap_status rmap_reuse_take(struct rmap_reuse_reader *reader, uint64_t n,
                                 struct rmap_portion_recorder *recorder, struct rmap_tally *tally,
                                 struct rmap_error *err) RMAP_MUST_USE;

#endif
