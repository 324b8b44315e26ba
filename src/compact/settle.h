/* SPDX-License-Identifier: MIT
 *
 * Predictions against the truth, for the segments of a whole portion.
 */
#ifndef RMAP_COMPACT_SETTLE_H
#define RMAP_COMPACT_SETTLE_H

#include "compact/batch.h"
#include "compact/few.h"
#include "compact/retrace.h"

/* Decoding: the columns of `out` that are asked for become the truth. */
enum rmap_status rmap_settle_decode(struct rmap_batch *batch, const struct rmap_retrace *r,
                                    bool one_by_one, struct rmap_portion *out,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* Encoding: the lanes of `r` take the differences. predicted: room of the encoder's.
 * *one_by_one_ret: the decoder must follow every ray by itself. */
enum rmap_status rmap_settle_encode(struct rmap_batch *batch, const struct rmap_retrace *r,
                                    struct rmap_portion *predicted, bool *one_by_one_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* The same where only a few rays need it. r: of all rays; of_few: of few->rows, into whose rows
 * `predicted` goes. RMAP_INTERNAL when a sample shows that the others were not predicted. */
enum rmap_status rmap_settle_encode_few(struct rmap_batch *batch, const struct rmap_retrace *r,
                                        const struct rmap_retrace *of_few,
                                        const struct rmap_few *few, struct rmap_portion *predicted,
                                        bool *one_by_one_ret, struct rmap_error *err) RMAP_MUST_USE;

#endif
