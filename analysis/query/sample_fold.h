/* SPDX-License-Identifier: MIT
 *
 * The ids of some of the matching rays as a fold (fold.h), so that receivers may decide what
 * matches.
 */
#ifndef RMAP_SAMPLE_FOLD_H
#define RMAP_SAMPLE_FOLD_H

#include "analysis/query/fold.h"
#include "analysis/query/quantity.h"
#include "analysis/query/sample.h"

/* Context: which of them. */
struct rmap_sample_order {
    uint64_t most; /* rays, >= 1 */
    bool by_hash;  /* the smallest hashes of (seed, id); else the smallest ids */
    uint64_t seed;
    bool or_none;                     /* more than `most` that match are refused */
    const struct rmap_quantities *of; /* the greatest values of it; NULL: as above. The fold then
                                         has its columns, too */
};

static inline struct rmap_sample_ray rmap_sample_ray_of(const struct rmap_sample_order *order,
                                                        uint64_t id)
{
    return (struct rmap_sample_ray){order->by_hash ? rmap_sample_key(order->seed, id) : id, id};
}

/* The key of a value, so that the greatest has the smallest, and back. */
uint64_t rmap_sample_key_of_value(double value);
double rmap_sample_value_of_key(uint64_t key);

/* State. Where more match than there may: RMAP_SYSTEM. */
struct rmap_sample_fold {
    const struct rmap_sample_order *order;
    struct rmap_sample sample;
    struct rmap_readings readings;
};
extern const struct rmap_fold_kind rmap_sample_kind;
#define RMAP_SAMPLE_COLUMNS RMAP_COLUMN_BIT(RMAP_RAY_id)

#endif
