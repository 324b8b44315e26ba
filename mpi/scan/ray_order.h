/* SPDX-License-Identifier: MIT
 *
 * Messages of rays that are handed out one by one in the order of their ids, as far as no message
 * to come can hold a smaller one.
 */
#ifndef RMAP_RAY_ORDER_H
#define RMAP_RAY_ORDER_H

#include "mpi/parallel/message.h"
#include "mpi/scan/ray_stream.h"

/* Begins with the map, the sink and the limit, all else 0. */
struct rmap_ray_order {
    const struct rmap_map *map;
    const struct rmap_ray_sink *sink;
    uint64_t limit, n; /* rays to hand out at most; handed out */
    struct rmap_held_rays *held;
    size_t n_held, cap_held;
};
void rmap_ray_order_fini(struct rmap_ray_order *order);

/* Rays of a portion of the map. Takes the message over, whatever happens. */
enum rmap_status rmap_ray_order_add(struct rmap_ray_order *order, size_t portion,
                                    struct rmap_message *message,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* All rays held with ids below `end`, until the limit is reached. */
enum rmap_status rmap_ray_order_hand_out(struct rmap_ray_order *order, uint64_t end,
                                         struct rmap_error *err) RMAP_MUST_USE;

#endif
