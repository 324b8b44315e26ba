/* SPDX-License-Identifier: MIT
 *
 * The rays of a portion that have to be traced again to find what their paths do not predict.
 */
#ifndef RMAP_COMPACT_FEW_H
#define RMAP_COMPACT_FEW_H

#include "compact/model.h"

/* Foretold rays that are traced again all the same: a tracer that promises too much is found out
 * where it happens. */
#define RMAP_FEW_STRIDE  256 /* one ray in so many, another one in each block */
#define RMAP_FEW_SAMPLES (RMAP_BLOCK_RAYS / RMAP_FEW_STRIDE)
#define RMAP_FEW_MAX     (RMAP_UNPREDICTED_MAX + RMAP_FEW_SAMPLES)

/* One per encoder. */
struct rmap_few {
    size_t n;
    uint32_t ray[RMAP_FEW_MAX]; /* of the portion, ascending */
    bool sample[RMAP_FEW_MAX];
    uint8_t channel[RMAP_FEW_MAX]; /* as struct rmap_retrace */
    size_t first_segment[RMAP_FEW_MAX], first_registration[RMAP_FEW_MAX]; /* of the portion */
    struct rmap_portion *rows; /* their rows alone, once gathered */
};

void rmap_few_destroy(struct rmap_few *few);

/* Which rays: unpredicted and some samples. False where every ray must be traced again. */
bool rmap_few_choose(struct rmap_few *few, const struct rmap_compact_model *model, uint64_t seed,
                     const struct rmap_portion *portion);

/* Their rows and channels, out of those of all rays. */
enum rmap_status rmap_few_gather(struct rmap_few *few, const struct rmap_portion *portion,
                                 const uint8_t *channel, struct rmap_error *err) RMAP_MUST_USE;

#endif
