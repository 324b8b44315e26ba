/* SPDX-License-Identifier: MIT
 *
 * A rank's share of a stream of rays: its threads pick the rays of its parts, in order and some
 * parts ahead; one thread takes the finished parts away, in order.
 */
#ifndef RMAP_RAY_PARTS_H
#define RMAP_RAY_PARTS_H

#include "analysis/query/query_mark.h"
#include "mpi/parallel/deal.h"
#include "mpi/parallel/message.h"

/* The picked rays of one portion. */
struct rmap_sheaf {
    size_t portion; /* of the map */
    struct rmap_message *message;
};

struct rmap_sheaves {
    struct rmap_sheaf *sheaf; /* [n], by portion */
    size_t n;
};
void rmap_sheaves_fini(struct rmap_sheaves *sheaves); /* zeroed: fine */

struct rmap_ray_parts;

/* Starts the threads. limit: rays of one portion, its first. All but err is borrowed. */
enum rmap_status rmap_ray_parts_start(const struct rmap_map *map, const struct rmap_pick *pick,
                                      const struct rmap_deal *deal, uint64_t limit, int rank,
                                      int n_thread, struct rmap_ray_parts **parts_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* The next part when it is finished (*done_ret), else nothing: never waits. The caller has what is
 * in it. The status of a part that failed. Not after the last part. */
enum rmap_status rmap_ray_parts_take(struct rmap_ray_parts *parts, bool *done_ret,
                                     struct rmap_sheaves *sheaves,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* Ends the threads, soon, wherever they are, and releases. NULL is fine. */
void rmap_ray_parts_stop(struct rmap_ray_parts *parts);

/* A short sleep between two looks. */
void rmap_ray_parts_nap(void);

#endif
