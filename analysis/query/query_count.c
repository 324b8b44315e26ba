/* SPDX-License-Identifier: MIT */
#include <math.h>

#include "analysis/query/query.h"
#include "base/alloc.h"
#include "trace/tally.h"

enum rmap_status rmap_count_init(struct rmap_count *count, size_t n_source, struct rmap_error *err)
{
    *count = (struct rmap_count){.source_weight = rmap_alloc(n_source, sizeof(double)),
                                 .source_weight_squared = rmap_alloc(n_source, sizeof(double))};
    if (count->source_weight && count->source_weight_squared)
        return RMAP_OK;
    rmap_count_fini(count);
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the sums of %zu sources", n_source);
}

void rmap_count_fini(struct rmap_count *count)
{
    rmap_free(count->source_weight);
    rmap_free(count->source_weight_squared);
    *count = (struct rmap_count){0};
}

void rmap_count_add(struct rmap_count *into, const struct rmap_count *from, size_t n_source)
{
    into->rays += from->rays;
    into->segments += from->segments;
    into->portions_read += from->portions_read;
    into->nbytes_read += from->nbytes_read;
    for (size_t s = 0; s < n_source; s++) {
        into->source_weight[s] += from->source_weight[s];
        into->source_weight_squared[s] += from->source_weight_squared[s];
    }
}

void rmap_count_flux(const struct rmap_count *count, const struct rmap_map *map, double *flux_ret,
                     double *standard_error_ret)
{
    const double *emitted = rmap_map_emitted(map);
    const double *flux_per_weight = rmap_map_flux_per_weight(map);
    double flux = 0.0, variance = 0.0;
    for (size_t s = 0; s < rmap_map_scene(map)->n_source; s++) {
        double n = emitted[s], w = count->source_weight[s];
        double w2 = count->source_weight_squared[s];
        flux += rmap_map_flux(map, s, w);
        variance += n < 2
                        ? (double)NAN
                        : flux_per_weight[s] * flux_per_weight[s] * n / (n - 1) * (w2 - w * w / n);
    }
    *flux_ret = flux;
    *standard_error_ret = sqrt(fmax(variance, 0.0));
    if (isnan(variance))
        *standard_error_ret = (double)NAN;
}
