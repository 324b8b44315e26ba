/* SPDX-License-Identifier: MIT
 *
 * What a piece says of the rays that share a path.
 */
#ifndef RMAP_COMPACT_PATH_SUM_H
#define RMAP_COMPACT_PATH_SUM_H

#include <stdint.h>

/* What the rays of a piece that have a path have in common. Least and greatest numbers, rounded
 * outwards, in the scene's length unit; NaN: nothing is known. */
struct rmap_path_sum {
    uint64_t rays; /* how many there are */
    float path_length[2], optical_path[2];
};

#endif
