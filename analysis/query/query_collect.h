/* SPDX-License-Identifier: MIT
 *
 * The matching rays of a scan, whole: read by a cursor of its own, and only from portions in which
 * some matched.
 */
#ifndef RMAP_QUERY_COLLECT_H
#define RMAP_QUERY_COLLECT_H

#include "io/map/map_reader.h"

struct rmap_collector {
    const struct rmap_map *map;
    struct rmap_portion *rays; /* NULL: none are wanted; borrowed */
    uint64_t n_left;           /* rays still to collect */
    struct rmap_cursor *whole; /* all columns; made when first needed */
    uint16_t *wide;            /* colours of a portion with fewer channels than `rays` has */
    size_t wide_cap;
};
void rmap_collector_fini(struct rmap_collector *collector);

/* True when there is nothing more to collect, though something was wanted. */
static inline bool rmap_collector_is_done(const struct rmap_collector *collector)
{
    return collector->rays && collector->n_left == 0;
}

/* Appends the marked rays of a portion, until enough are there. match: [n_ray], 0 or not. */
enum rmap_status rmap_collector_add(struct rmap_collector *collector, size_t portion,
                                    const uint8_t *match, struct rmap_error *err) RMAP_MUST_USE;

#endif
