/* SPDX-License-Identifier: MIT
 *
 * How many rays took each of more paths than memory holds: a Count-Min sketch (Cormode and
 * Muthukrishnan 2005, doi:10.1016/j.jalgor.2003.12.001). Linear: any order of adding and merging
 * gives the same numbers. An estimate is never too small; with N rays in all it is too large by
 * more than e N / 2^20 for fewer than one path in fifty (e^-4).
 */
#ifndef RMAP_PATH_SKETCH_H
#define RMAP_PATH_SKETCH_H

#include "analysis/table/key_sums.h"

enum { RMAP_PATH_SKETCH_ROWS = 4, RMAP_PATH_SKETCH_WIDTH = 1 << 20 };
#define RMAP_PATH_SKETCH_NBYTES                                                                    \
    ((size_t)RMAP_PATH_SKETCH_ROWS * RMAP_PATH_SKETCH_WIDTH * sizeof(uint32_t))

struct rmap_path_sketch {
    uint32_t *rays; /* [ROWS][WIDTH], saturating */
};

enum rmap_status rmap_path_sketch_init(struct rmap_path_sketch *sketch,
                                       struct rmap_error *err) RMAP_MUST_USE;
void rmap_path_sketch_fini(struct rmap_path_sketch *sketch);

void rmap_path_sketch_add(struct rmap_path_sketch *sketch, struct rmap_key key, uint64_t n_ray);
void rmap_path_sketch_merge(struct rmap_path_sketch *into, const struct rmap_path_sketch *from);
uint32_t rmap_path_sketch_estimate(const struct rmap_path_sketch *sketch, struct rmap_key key);

#endif
