/* SPDX-License-Identifier: MIT
 *
 * What the loops over the rays of a pack share. They have no branches, so that the compiler turns
 * them into vector instructions; for the files of the kernel alone.
 */
#ifndef RMAP_COMPACT_WAVE_LANES_H
#define RMAP_COMPACT_WAVE_LANES_H

#include "compact/wave.h"

#define W    RMAP_WAVE_WIDTH
#define EACH for (int i = 0; i < W; i++)

/* A wider instruction set where the machine has one. Results are the same: none of them contracts
 * multiplications and additions. */
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__OPTIMIZE__)
#define WIDE __attribute__((target_clones("avx2", "default")))
#else
#define WIDE
#endif

static inline void normalise(double x[W], double y[W], double z[W])
{
    EACH
    {
        double s = 1.0 / sqrt(x[i] * x[i] + y[i] * y[i] + z[i] * z[i]);
        x[i] = x[i] * s;
        y[i] = y[i] * s;
        z[i] = z[i] * s;
    }
}

#endif
