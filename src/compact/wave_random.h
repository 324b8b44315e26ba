/* SPDX-License-Identifier: MIT
 *
 * Random numbers and angles of a pack of rays; for the files of the kernel alone.
 */
#ifndef RMAP_COMPACT_WAVE_RANDOM_H
#define RMAP_COMPACT_WAVE_RANDOM_H

#include "compact/wave_lanes.h"
#include "trace/azimuth.h"

static inline void azimuth(const double turns[W], double cosine[W], double sine[W])
{
    EACH
    {
        rmap_azimuth(turns[i], &cosine[i], &sine[i]);
    }
}

/* Philox4x32-10 of base/rng.h (Salmon et al. 2011, doi:10.1145/2063384.2063405). */
static inline void draw(uint64_t seed, uint32_t c[4][W])
{
    uint32_t key0 = (uint32_t)seed, key1 = (uint32_t)(seed >> 32);
    for (int round = 0; round < 10; round++) {
        EACH
        {
            uint64_t p0 = (uint64_t)c[0][i] * 0xD2511F53u, p1 = (uint64_t)c[2][i] * 0xCD9E8D57u;
            uint32_t c0 = (uint32_t)(p1 >> 32) ^ c[1][i] ^ key0;
            uint32_t c2 = (uint32_t)(p0 >> 32) ^ c[3][i] ^ key1;
            c[0][i] = c0;
            c[1][i] = (uint32_t)p1;
            c[2][i] = c2;
            c[3][i] = (uint32_t)p0;
        }
        key0 += 0x9E3779B9u;
        key1 += 0xBB67AE85u;
    }
}

static inline void uniform(const uint32_t bits[W], double out[W])
{
    EACH
    {
        out[i] = ((double)bits[i] + 0.5) * 0x1p-32;
    }
}

#endif
