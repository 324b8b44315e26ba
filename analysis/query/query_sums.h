/* SPDX-License-Identifier: MIT
 *
 * Sums over matching rays, of what a portion's columns say. Weights that are all 1 are numbers of
 * rays: their sums are exact either way.
 */
#ifndef RMAP_QUERY_SUMS_H
#define RMAP_QUERY_SUMS_H

#include "analysis/query/query.h"

bool rmap_weights_are_one(const double *weight, size_t n);

/* Of more sources rays are not counted: weights are added. */
enum { RMAP_SUMS_SOURCES_MAX = 256 };

/* What a portion's columns say, whichever rays match. */
struct rmap_sums_facts {
    size_t n_source;
    bool are_counted; /* weights are 1, sources few */
};

/* RMAP_FORMAT when a source is none of n_source. */
enum rmap_status rmap_sums_look(const struct rmap_portion *portion, size_t n_source,
                                struct rmap_sums_facts *facts,
                                struct rmap_error *err) RMAP_MUST_USE;

/* outcome: [n_ray], bit 1 set where a ray matches. */
void rmap_sums_add_rays(struct rmap_count *count, const struct rmap_portion *portion,
                        const uint8_t *outcome, const struct rmap_sums_facts *facts);

#endif
