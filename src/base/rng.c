/* SPDX-License-Identifier: MIT
 *
 * Random numbers that are a pure function of (seed, ray id, step, slot): Philox4x32-10 (Salmon et
 * al. 2011, doi:10.1145/2063384.2063405), key = seed, counter = (ray id 64 bits, step 32, slot
 * 32).
 */
#include "base/rng.h"

#include <Random123/philox.h>

void rmap_rng(uint64_t seed, uint64_t ray, uint32_t step, enum rmap_rng_slot slot,
              double uniform[4])
{
    philox4x32_key_t key = {{(uint32_t)seed, (uint32_t)(seed >> 32)}};
    philox4x32_ctr_t bits = {{(uint32_t)ray, (uint32_t)(ray >> 32), step, (uint32_t)slot}};
    bits = philox4x32(bits, key);
    for (int i = 0; i < 4; i++)
        uniform[i] = ((double)bits.v[i] + 0.5) * 0x1p-32;
}
