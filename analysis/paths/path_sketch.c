/* SPDX-License-Identifier: MIT
 *
 * How many rays took each of more paths than memory holds: a Count-Min sketch (Cormode and
 * Muthukrishnan 2005, doi:10.1016/j.jalgor.2003.12.001).
 */
#include "analysis/paths/path_sketch.h"

#include "base/alloc.h"

enum { ROW_BITS = 20, KEPT_BITS = 24 /* of key.high, below which no hash stands */ };

enum rmap_status rmap_path_sketch_init(struct rmap_path_sketch *sketch, struct rmap_error *err)
{
    sketch->rays = rmap_alloc(RMAP_PATH_SKETCH_NBYTES, 1);
    if (!sketch->rays)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a sketch of paths");
    return RMAP_OK;
}

void rmap_path_sketch_fini(struct rmap_path_sketch *sketch)
{
    rmap_free(sketch->rays);
    *sketch = (struct rmap_path_sketch){0};
}

/* Place of the key in a row: bits of its own for each. */
static inline size_t place_of(struct rmap_key key, int row)
{
    uint64_t bits = row < 3 ? key.low >> (ROW_BITS * row) : key.high >> KEPT_BITS;
    return (size_t)row * RMAP_PATH_SKETCH_WIDTH + (size_t)(bits & (RMAP_PATH_SKETCH_WIDTH - 1));
}

static uint32_t add_saturating(uint32_t a, uint64_t b)
{
    return b > UINT32_MAX - a ? UINT32_MAX : a + (uint32_t)b;
}

void rmap_path_sketch_add(struct rmap_path_sketch *sketch, struct rmap_key key, uint64_t n_ray)
{
    for (int row = 0; row < RMAP_PATH_SKETCH_ROWS; row++) {
        uint32_t *rays = &sketch->rays[place_of(key, row)];
        *rays = add_saturating(*rays, n_ray);
    }
}

void rmap_path_sketch_merge(struct rmap_path_sketch *into, const struct rmap_path_sketch *from)
{
    for (size_t i = 0; i < (size_t)RMAP_PATH_SKETCH_ROWS * RMAP_PATH_SKETCH_WIDTH; i++)
        into->rays[i] = add_saturating(into->rays[i], from->rays[i]);
}

uint32_t rmap_path_sketch_estimate(const struct rmap_path_sketch *sketch, struct rmap_key key)
{
    uint32_t least = UINT32_MAX;
    for (int row = 0; row < RMAP_PATH_SKETCH_ROWS; row++) {
        uint32_t rays = sketch->rays[place_of(key, row)];
        least = rays < least ? rays : least;
    }
    return least;
}
