/* SPDX-License-Identifier: MIT
 *
 * The N of many rays that have the smallest keys, whatever order they come in: with a hash as the
 * key a random sample that anybody finds again, with the id itself the first N rays.
 */
#ifndef RMAP_SAMPLE_H
#define RMAP_SAMPLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

struct rmap_sample_ray {
    uint64_t key, id;
};

/* Zeroed but for `most`: empty. */
struct rmap_sample {
    uint64_t most; /* rays to keep, >= 1 */
    size_t n, cap;
    struct rmap_sample_ray *ray; /* [n], a heap: the largest (key, id) first */
};

/* XXH3-64 of 16 bytes: seed, then id, both little-endian. */
uint64_t rmap_sample_key(uint64_t seed, uint64_t id);

/* Whether a ray would be kept. */
bool rmap_sample_wants(const struct rmap_sample *sample, struct rmap_sample_ray ray);

/* Keeps the ray if it is one of the smallest so far; of equal keys the smaller id. RMAP_SYSTEM. */
enum rmap_status rmap_sample_add(struct rmap_sample *sample, struct rmap_sample_ray ray,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* The ids kept, ascending [sample->n]; *id_ret: rmap_free. */
enum rmap_status rmap_sample_ids(const struct rmap_sample *sample, uint64_t **id_ret,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* Ascending. */
void rmap_sort_ids(uint64_t *id, size_t n);

void rmap_sample_fini(struct rmap_sample *sample);

#endif
