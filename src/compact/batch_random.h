/* SPDX-License-Identifier: MIT
 *
 * Random numbers of a pack of rays; for the files of the kernel alone.
 */
#ifndef RMAP_COMPACT_BATCH_RANDOM_H
#define RMAP_COMPACT_BATCH_RANDOM_H

#include "compact/batch_lanes.h"
#include "formula/turn.h"

/* Four random numbers for each counter, in its place. */
void rmap_batch_draw(uint64_t seed, uint32_t counter[4][W]);

static inline void uniform(const uint32_t bits[W], double out[W])
{
    EACH
    {
        out[i] = ((double)bits[i] + 0.5) * 0x1p-32;
    }
}

#endif
