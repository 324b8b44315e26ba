/* SPDX-License-Identifier: MIT
 *
 * Philox4x32-10 of base/rng.h (Salmon et al. 2011, doi:10.1145/2063384.2063405) for a pack of rays.
 */
#include "compact/batch_random.h"

#include "base/wide.h"

#define KEY0   0x9E3779B9u
#define KEY1   0xBB67AE85u
#define TIMES0 0xD2511F53u
#define TIMES1 0xCD9E8D57u
#define ROUNDS 10

RMAP_WIDE void rmap_batch_draw(uint64_t seed, uint32_t c[4][W])
{
    uint32_t key0 = (uint32_t)seed, key1 = (uint32_t)(seed >> 32);
    for (int round = 0; round < ROUNDS; round++, key0 += KEY0, key1 += KEY1) {
        EACH
        {
            uint64_t p0 = (uint64_t)c[0][i] * TIMES0, p1 = (uint64_t)c[2][i] * TIMES1;
            uint32_t c0 = (uint32_t)(p1 >> 32) ^ c[1][i] ^ key0;
            uint32_t c2 = (uint32_t)(p0 >> 32) ^ c[3][i] ^ key1;
            c[0][i] = c0;
            c[1][i] = (uint32_t)p1;
            c[2][i] = c2;
            c[3][i] = (uint32_t)p0;
        }
    }
}
