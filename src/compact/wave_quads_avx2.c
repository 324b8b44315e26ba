/* SPDX-License-Identifier: MIT
 *
 * wave_quads.h with the vectors of AVX2.
 */
#include "compact/wave.h"

#if RMAP_WAVE_AVX2
#include <math.h>
#include <string.h>

#pragma GCC target("avx2")
#define WIDE
#include "compact/wave_quads.h"

void rmap_wave_meet_flats_avx2(struct rmap_wave_pack *pack)
{
    meet_flats(pack);
}

void rmap_wave_meet_meshes_avx2(struct rmap_wave_pack *pack)
{
    meet_meshes(pack);
}

void rmap_wave_load_avx2(struct rmap_wave_pack *pack)
{
    load(pack);
}

void rmap_wave_store_avx2(const struct rmap_wave_pack *pack,
                          struct rmap_wave_ray *const to[RMAP_WAVE_WIDTH])
{
    store(pack, to);
}
#endif
