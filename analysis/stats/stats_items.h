/* SPDX-License-Identifier: MIT
 *
 * Readings of one fine bin, in no order, among which a share of the flux is reached.
 */
#ifndef RMAP_STATS_ITEMS_H
#define RMAP_STATS_ITEMS_H

#include <stddef.h>
#include <stdint.h>

struct rmap_stats_item {
    double value, weight;
    uint32_t source;
};

/* Flux of readings: `below` that of all lower ones. */
struct rmap_stats_flux {
    const double *per_weight; /* [n_source] */
    size_t n_source;
    double below, target;
};

/* The first value at which the flux reaches the target; the greatest where none does. Part k of the
 * items is [first[k], first[k + 1]), and holds no value greater than one of a later part; n_part of
 * them, one at least with an item. Flux sums up per source, then over sources: the order of equal
 * values does not matter, nor that of items in a part, which is changed. weight: [n_source]
 * scratch. */
double rmap_stats_items_at(struct rmap_stats_item *item, const size_t *first, size_t n_part,
                           const struct rmap_stats_flux *flux, double *weight);

#endif
