/* SPDX-License-Identifier: MIT */
#include "analysis/path_order.h"

#include <math.h>

#include "base/alloc.h"

/* Of what a mirror is meant to reflect. */
static const double MIRRORS = 0.5;

/* At normal incidence from air; of a metal by Fresnel's equation, ((n-1)^2 + k^2)/((n+1)^2 + k^2).
 */
static double specular_reflectance(const struct rmap_surface *surface, int channel)
{
    const double n = surface->metal_n[channel],
                 kk = surface->metal_k[channel] * surface->metal_k[channel];
    return surface->is_metal ? ((n - 1.0) * (n - 1.0) + kk) / ((n + 1.0) * (n + 1.0) + kk)
                             : surface->reflect_specular[channel];
}

static bool makes_ghosts(const struct rmap_scene *scene, int32_t surface)
{
    if (surface < 0 || rmap_scene_transmits(scene, surface))
        return surface >= 0;
    double greatest = 0.0;
    for (int c = 0; c < scene->channels.n; c++)
        greatest = fmax(greatest, specular_reflectance(&scene->surface[surface], c));
    return greatest > 0.0 && greatest < MIRRORS;
}

enum rmap_status rmap_path_order_init(struct rmap_path_order *order, const struct rmap_scene *scene,
                                      struct rmap_error *err)
{
    *order = (struct rmap_path_order){.n_object = scene->n_object};
    order->makes_ghosts = rmap_alloc(scene->n_object + 1, 1);
    if (!order->makes_ghosts)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu objects", scene->n_object);
    for (size_t o = 0; o < scene->n_object; o++)
        order->makes_ghosts[o] = makes_ghosts(scene, scene->object[o].surface_front) ||
                                 makes_ghosts(scene, scene->object[o].surface_back);
    return RMAP_OK;
}

void rmap_path_order_fini(struct rmap_path_order *order)
{
    rmap_free(order->makes_ghosts);
    *order = (struct rmap_path_order){0};
}

/* Adds up legs [first, last) of the portion. */
static void add_steps(const struct rmap_path_order *order, const struct rmap_portion *portion,
                      size_t first, size_t last, uint32_t *ghost, uint32_t *scatter)
{
    const int32_t *object = portion->segment.object;
    const uint32_t *event = portion->segment.event;
    for (size_t i = first; i < last; i++) {
        *ghost += rmap_path_ghost_step(order, object[i], event[i]);
        *scatter += rmap_path_scatter_step(event[i]);
    }
}

void rmap_path_orders_of_rays(const struct rmap_path_order *order,
                              const struct rmap_portion *portion, uint32_t *ghost,
                              uint32_t *scatter)
{
    size_t first = 0;
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_RAY]; i++) {
        size_t last = first + portion->ray.segment_count[i];
        ghost[i] = scatter[i] = 0;
        add_steps(order, portion, first, last, &ghost[i], &scatter[i]);
        first = last;
    }
}

void rmap_path_orders_of_registrations(const struct rmap_path_order *order,
                                       const struct rmap_portion *portion, uint32_t *ghost,
                                       uint32_t *scatter)
{
    size_t first = 0, row = 0;
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_RAY]; i++) {
        const size_t n_leg = portion->ray.segment_count[i];
        const size_t end = row + portion->ray.registration_count[i];
        size_t at = 0;
        uint32_t sum[2] = {0, 0};
        for (; row < end; row++) {
            size_t leg = portion->registration.segment[row];
            leg = leg < n_leg ? leg : n_leg;
            if (leg < at)
                at = sum[0] = sum[1] = 0;
            add_steps(order, portion, first + at, first + leg, &sum[0], &sum[1]);
            at = leg;
            ghost[row] = sum[0];
            scatter[row] = sum[1];
        }
        first += n_leg;
    }
}
