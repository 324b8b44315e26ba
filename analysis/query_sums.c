/* SPDX-License-Identifier: MIT
 *
 * Without a branch per ray: which rays match is random.
 */
#include "analysis/query_sums.h"

static void add_source(struct rmap_count *count, size_t source, double rays)
{
    count->source_weight[source] += rays;
    count->source_weight_squared[source] += rays;
}

/* Rays and segments; returns the rays. */
static uint64_t add_numbers(struct rmap_count *count, const uint32_t *restrict segment_count,
                            const uint8_t *restrict verdict, size_t n)
{
    uint64_t segments = 0, rays = 0;
    for (size_t i = 0; i < n; i++) {
        uint32_t match = verdict[i] >> 1;
        rays += match;
        segments += segment_count[i] & (0u - match);
    }
    count->rays += rays;
    count->segments += segments;
    return rays;
}

enum rmap_status rmap_sums_add_rays(struct rmap_count *count, const struct rmap_portion *portion,
                                    const uint8_t *verdict, size_t n_source, struct rmap_error *err)
{
    const struct rmap_ray_columns *ray = &portion->ray;
    size_t n_ray = portion->n_row[RMAP_TABLE_RAY];
    (void)add_numbers(count, ray->segment_count, verdict, n_ray);
    for (size_t i = 0; i < n_ray; i++) {
        size_t source = (size_t)ray->source[i];
        double weight = verdict[i] >> 1 ? ray->weight[i] : 0.0;
        if (source >= n_source)
            return rmap_error_set(
                err, RMAP_FORMAT, "a ray of the portion from id %llu on has source %d of %zu",
                (unsigned long long)portion->first_ray, (int)ray->source[i], n_source);
        count->source_weight[source] += weight;
        count->source_weight_squared[source] += weight * weight;
    }
    return RMAP_OK;
}

void rmap_sums_add_paths(struct rmap_count *count, const struct rmap_history_view *view,
                         const struct rmap_ray_columns *paths, const uint32_t *rays)
{
    for (size_t k = 0; k < view->n_path; k++) {
        uint32_t row = view->path_row[k];
        count->rays += rays[k];
        count->segments += (uint64_t)rays[k] * paths->segment_count[row];
        add_source(count, (size_t)paths->source[row], rays[k]);
    }
}

void rmap_sums_add_rows(struct rmap_count *count, const struct rmap_history_view *view,
                        const uint8_t *verdict)
{
    size_t n_ray = view->n_row[RMAP_TABLE_RAY];
    uint64_t rays = add_numbers(count, view->segment_count, verdict, n_ray);
    if (!view->kind)
        add_source(count, (size_t)view->kind_source[0], (double)rays);
    else if (rays > 0)
        for (size_t i = 0; i < n_ray; i++)
            add_source(count, (size_t)view->kind_source[view->kind[i]], verdict[i] >> 1);
}
