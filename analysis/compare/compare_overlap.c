/* SPDX-License-Identifier: MIT
 *
 * Whether the rays of two maps are drawn independently: random numbers follow from the seed and
 * the ray id, so rays of the same seed and id are the same ones in the same scene, and akin in
 * another.
 */
#include "analysis/compare/compare_overlap.h"

#include <string.h>

#include "base/alloc.h"
#include "io/mesh/bundle_pack.h"

static bool same_digest(struct rmap_digest a, struct rmap_digest b)
{
    return a.low == b.low && a.high == b.high;
}

/* The scene files' bytes and all that was chosen of them. */
static enum rmap_status compare_scenes(const struct rmap_map *const map[2], bool *same,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint8_t *blob[2] = {NULL, NULL};
    size_t nbytes[2] = {0, 0};
    for (int k = 0; k < 2; k++)
        RMAP_TRY(rmap_bundle_pack(rmap_map_bundle(map[k]), &blob[k], &nbytes[k], err));
    *same = nbytes[0] == nbytes[1] && memcmp(blob[0], blob[1], nbytes[0]) == 0;
out:
    for (int k = 0; k < 2; k++)
        rmap_free(blob[k]);
    return st;
}

/* Rays that a portion has with ids in [first, end); of one with gaps, at most. */
static uint64_t rays_within(const struct rmap_portion_info *portion, uint64_t first, uint64_t end)
{
    uint64_t n = portion->n_row[RMAP_TABLE_RAY];
    return end - first < n ? end - first : n;
}

enum rmap_status rmap_compare_overlap(const struct rmap_map *const map[2],
                                      struct rmap_overlap *overlap, struct rmap_error *err)
{
    struct rmap_map_summary summary[2];
    size_t at[2] = {0, 0};
    *overlap = (struct rmap_overlap){0};
    for (int k = 0; k < 2; k++)
        rmap_map_summarise(map[k], &summary[k]);
    overlap->same_seed = summary[0].seed == summary[1].seed;
    overlap->identical = same_digest(summary[0].digest, summary[1].digest) &&
                         summary[0].n_row[RMAP_TABLE_RAY] == summary[1].n_row[RMAP_TABLE_RAY];
    enum rmap_status st = compare_scenes(map, &overlap->same_scene, err);
    if (st != RMAP_OK || !overlap->same_seed)
        return st;
    while (at[0] < rmap_map_n_portion(map[0]) && at[1] < rmap_map_n_portion(map[1])) {
        const struct rmap_portion_info *a = rmap_map_portion(map[0], at[0]);
        const struct rmap_portion_info *b = rmap_map_portion(map[1], at[1]);
        uint64_t a_end = rmap_portion_end(a), b_end = rmap_portion_end(b);
        uint64_t first = a->first_ray > b->first_ray ? a->first_ray : b->first_ray;
        uint64_t end = a_end < b_end ? a_end : b_end;
        if (first < end) {
            uint64_t n = rays_within(a, first, end), m = rays_within(b, first, end);
            overlap->rays += n < m ? n : m;
        }
        /* the very same block, though the scene's file be called otherwise */
        if (a->first_ray == b->first_ray && same_digest(a->digest, b->digest))
            overlap->same_scene = true;
        at[a_end > b_end]++;
    }
    return RMAP_OK;
}
