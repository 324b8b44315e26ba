/* SPDX-License-Identifier: MIT
 *
 * Without a branch per ray: which rays match is random.
 */
#include "analysis/query/query_sums.h"

#include <string.h>

#include <stdbool.h>

#include "base/wide.h"
#include "portion/weight.h"

static void add_source(struct rmap_count *count, size_t source, double rays)
{
    count->source_weight[source] += rays;
    count->source_weight_squared[source] += rays;
}

/* Rays and segments, in 32 bits. */
struct sums {
    uint32_t rays, segments;
};

RMAP_WIDE static struct sums add_up(const uint32_t *restrict segment_count,
                                    const uint8_t *restrict outcome, size_t n)
{
    uint32_t rays = 0, segments = 0;
    for (size_t i = 0; i < n; i++) {
        uint32_t match = outcome[i] >> 1;
        rays += match;
        segments += segment_count[i] & (0u - match);
    }
    return (struct sums){rays, segments};
}

/* Rays and segments of a portion, n_segment in all: one that 32 bits do not count is taken ray by
 * ray. Returns the rays. */
static uint64_t add_numbers(struct rmap_count *count, const uint32_t *segment_count,
                            const uint8_t *outcome, size_t n, size_t n_segment)
{
    const size_t step = n_segment <= UINT32_MAX && n <= UINT32_MAX ? n : 1;
    uint64_t rays = 0;
    for (size_t i = 0; i < n; i += step) {
        struct sums sums = add_up(segment_count + i, outcome + i, step);
        rays += sums.rays;
        count->segments += sums.segments;
    }
    count->rays += rays;
    return rays;
}

RMAP_WIDE static uint64_t any_is_other(const double *weight, size_t n)
{
    const double one = 1.0;
    uint64_t other = 0, bits, wanted;
    memcpy(&wanted, &one, sizeof wanted);
    for (size_t i = 0; i < n; i++) {
        memcpy(&bits, weight + i, sizeof bits);
        other |= bits ^ wanted;
    }
    return other;
}

bool rmap_weights_are_one(const double *weight, size_t n)
{
    return !any_is_other(weight, n);
}

/* Weights of 1 are counted, which is the same sum. Of few sources, each is looked for in all rays
 * at once. */
enum { SOURCE_FEW = 4 };

RMAP_WIDE static uint32_t count_source(const int32_t *restrict source,
                                       const uint8_t *restrict outcome, size_t n, int32_t which)
{
    uint32_t rays = 0;
    for (size_t i = 0; i < n; i++)
        rays += (outcome[i] >> 1) & (uint32_t)(source[i] == which);
    return rays;
}

/* n_match: rays that match, whatever their source: of the first one those that are no other's. */
static void count_sources(struct rmap_count *count, const int32_t *source, const uint8_t *outcome,
                          size_t n, size_t n_source, uint64_t n_match)
{
    uint32_t rays[RMAP_SUMS_SOURCES_MAX] = {0};
    if (n_source <= SOURCE_FEW)
        for (size_t s = 1; s < n_source; s++)
            rays[s] = count_source(source, outcome, n, (int32_t)s);
    else
        for (size_t i = 0; i < n; i++)
            rays[source[i]] += outcome[i] >> 1;
    for (size_t s = 1; s < n_source; s++) {
        add_source(count, s, rays[s]);
        n_match -= rays[s];
    }
    if (n_source > 0)
        add_source(count, 0, (double)n_match);
}

RMAP_WIDE static bool are_below(const int32_t *source, size_t n, size_t n_source)
{
    uint32_t most = 0;
    for (size_t i = 0; i < n; i++)
        most = (uint32_t)source[i] > most ? (uint32_t)source[i] : most;
    return n == 0 || most < n_source;
}

enum rmap_status rmap_sums_look(const struct rmap_portion *portion, size_t n_source,
                                struct rmap_sums_facts *facts, struct rmap_error *err)
{
    const size_t n_ray = portion->n_row[RMAP_TABLE_RAY];
    const bool are_one =
        n_source <= RMAP_SUMS_SOURCES_MAX && rmap_weights_are_one(portion->ray.weight, n_ray);
    *facts = (struct rmap_sums_facts){n_source, are_one};
    if (!are_below(portion->ray.source, n_ray, n_source))
        return rmap_error_set(err, RMAP_FORMAT,
                              "a ray of the portion from id %llu on has a source beyond the %zu",
                              (unsigned long long)portion->first_ray, n_source);
    return RMAP_OK;
}

void rmap_sums_add_rays(struct rmap_count *count, const struct rmap_portion *portion,
                        const uint8_t *outcome, const struct rmap_sums_facts *facts)
{
    const struct rmap_ray_columns *ray = &portion->ray;
    size_t n_ray = portion->n_row[RMAP_TABLE_RAY];
    uint64_t n_match =
        add_numbers(count, ray->segment_count, outcome, n_ray, portion->n_row[RMAP_TABLE_SEGMENT]);
    if (facts->are_counted) {
        count_sources(count, ray->source, outcome, n_ray, facts->n_source, n_match);
        return;
    }
    for (size_t i = 0; i < n_ray; i++) {
        double weight = outcome[i] >> 1 ? ray->weight[i] : 0.0;
        count->source_weight[ray->source[i]] += weight;
        count->source_weight_squared[ray->source[i]] += rmap_weight_squared(weight);
    }
}
