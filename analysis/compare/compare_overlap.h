/* SPDX-License-Identifier: MIT
 *
 * Whether the rays of two maps are drawn independently: random numbers follow from the seed and the
 * ray id, so rays of the same seed and id are the same ones in the same scene, and akin in another.
 */
#ifndef RMAP_COMPARE_OVERLAP_H
#define RMAP_COMPARE_OVERLAP_H

#include <stdbool.h>

#include "io/map/map_reader.h"

struct rmap_overlap {
    bool same_seed, same_scene;
    bool identical; /* equal digests: the maps hold the same rays and nothing else */
    uint64_t rays;  /* ids that both maps have, of the same seed; 0 for other seeds */
};

/* RMAP_SYSTEM. */
enum rmap_status rmap_compare_overlap(const struct rmap_map *const map[2],
                                      struct rmap_overlap *overlap,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
