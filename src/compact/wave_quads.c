/* SPDX-License-Identifier: MIT
 *
 * wave_quads.h with the vectors of any machine, unless it has wider ones.
 */
#include "compact/wave_quads.h"

#if RMAP_WAVE_AVX2
static bool is_wide(void)
{
    return __builtin_cpu_supports("avx2");
}
#else
static bool is_wide(void)
{
    return false;
}
#define rmap_wave_load_avx2        load
#define rmap_wave_store_avx2       store
#define rmap_wave_meet_flats_avx2  meet_flats
#define rmap_wave_meet_meshes_avx2 meet_meshes
#endif

void rmap_wave_meet_flats(struct rmap_wave_pack *pack)
{
    if (is_wide())
        rmap_wave_meet_flats_avx2(pack);
    else
        meet_flats(pack);
}

void rmap_wave_meet_meshes(struct rmap_wave_pack *pack)
{
    if (is_wide())
        rmap_wave_meet_meshes_avx2(pack);
    else
        meet_meshes(pack);
}

void rmap_wave_load(struct rmap_wave_pack *pack)
{
    if (is_wide())
        rmap_wave_load_avx2(pack);
    else
        load(pack);
}

void rmap_wave_store(const struct rmap_wave_pack *pack,
                     struct rmap_wave_ray *const to[RMAP_WAVE_WIDTH])
{
    if (is_wide())
        rmap_wave_store_avx2(pack, to);
    else
        store(pack, to);
}
