/* SPDX-License-Identifier: MIT
 *
 * How often light was turned out of its way: the two orders by which stray light is counted.
 */
#include "analysis/criterion/path_order.h"

#include <math.h>

#include "base/alloc.h"
#include "scene/coat.h"

/* Of what a mirror is meant to reflect. */
static const double MIRRORS = 0.5;

/* What a scatter model leaves of it. Roughness takes little. */
static double left_specular(const struct rmap_scatter *its, int channel, double all)
{
    const struct rmap_scattering at = {
        .scatter = its, .channel = channel, .n1 = 1.0, .n2 = 1.0, .in = {0.0, 0.0, -1.0}};
    if (its->model == RMAP_SCATTER_UNIFIED)
        return all * its->shape[RMAP_SHAPE_SPIKE][channel];
    if (rmap_scatter_is_facets(its))
        return 0.0;
    return its->by_roughness ? all : all - its->amount[channel] * rmap_lobe_total(&at);
}

/* At normal incidence from air. */
static double specular_reflectance(const struct rmap_scene *scene,
                                   const struct rmap_surface *surface, int channel)
{
    const double all = surface->is_metal ? rmap_metal_coat(scene, surface, channel, 1.0, 1.0)
                                         : surface->reflect_specular[channel];
    const struct rmap_scatter *its = rmap_surface_scatter(scene, surface, false);
    return its && (surface->reflect_is_total || rmap_scatter_is_facets(its))
               ? left_specular(its, channel, all)
               : all;
}

/* The most that a surface reflects of any channel; of one that transmits, which may be bare, it
 * does not matter. */
static double most_reflected(const struct rmap_scene *scene, int32_t surface)
{
    double most = 0.0;
    for (int c = 0; surface >= 0 && c < scene->channels.n; c++)
        most = fmax(most, specular_reflectance(scene, &scene->surface[surface], c));
    return most;
}

static bool makes_ghosts(const struct rmap_scene *scene, int32_t surface)
{
    if (surface < 0 || rmap_scene_transmits(scene, surface))
        return surface >= 0;
    const double most = most_reflected(scene, surface);
    return most > 0.0 && most < MIRRORS;
}

/* Which sides of an object make ghosts; both, where there is no need to look at which one it was.
 */
static uint8_t sides_of(const struct rmap_scene *scene, const struct rmap_object *object)
{
    const int32_t surface[2] = {object->surface_front, object->surface_back};
    const bool makes[2] = {makes_ghosts(scene, surface[0]), makes_ghosts(scene, surface[1])};
    if (makes[0] == makes[1])
        return makes[0] ? 3 : 0;
    if (most_reflected(scene, surface[makes[0]]) > 0.0) /* the one that makes none */
        return makes[0] ? 1 : 2;
    return 3;
}

enum rmap_status rmap_path_order_init(struct rmap_path_order *order, const struct rmap_scene *scene,
                                      struct rmap_error *err)
{
    *order = (struct rmap_path_order){.scene = scene,
                                      .n_object = scene->n_object,
                                      .columns = RMAP_COLUMN_BIT(RMAP_RAY_segment_count) |
                                                 RMAP_COLUMN_BIT(RMAP_RAY_registration_count) |
                                                 RMAP_COLUMN_BIT(RMAP_SEGMENT_object) |
                                                 RMAP_COLUMN_BIT(RMAP_SEGMENT_event) |
                                                 RMAP_COLUMN_BIT(RMAP_REGISTRATION_segment)};
    order->makes_ghosts = rmap_alloc(scene->n_object + 1, 1);
    if (!order->makes_ghosts)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu objects", scene->n_object);
    for (size_t o = 0; o < scene->n_object; o++) {
        order->makes_ghosts[o] = sides_of(scene, &scene->object[o]);
        order->by_side |= order->makes_ghosts[o] == 1 || order->makes_ghosts[o] == 2;
    }
    if (order->by_side)
        order->columns |= rmap_side_columns(scene, order->makes_ghosts);
    return RMAP_OK;
}

void rmap_path_order_fini(struct rmap_path_order *order)
{
    rmap_free(order->makes_ghosts);
    *order = (struct rmap_path_order){0};
}

/* A ray of the portion, whose segments begin at a row. */
struct walked {
    const struct rmap_portion *portion;
    size_t ray, row;
};

/* Adds up its segments [first, last). */
static void add_steps(const struct rmap_path_order *order, const struct walked *its, size_t first,
                      size_t last, uint32_t *ghost, uint32_t *scatter)
{
    for (size_t i = its->row + first; i < its->row + last; i++) {
        *ghost += rmap_path_ghost_step(order, its->portion, i, its->ray, its->row);
        *scatter += rmap_path_scatter_step(its->portion->segment.event[i]);
    }
}

void rmap_path_orders_of_rays(const struct rmap_path_order *order,
                              const struct rmap_portion *portion, uint32_t *ghost,
                              uint32_t *scatter)
{
    size_t first = 0;
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_RAY]; i++) {
        const size_t n_segment = portion->ray.segment_count[i];
        ghost[i] = scatter[i] = 0;
        add_steps(order, &(struct walked){portion, i, first}, 0, n_segment, &ghost[i], &scatter[i]);
        first += n_segment;
    }
}

void rmap_path_orders_of_registrations(const struct rmap_path_order *order,
                                       const struct rmap_portion *portion, uint32_t *ghost,
                                       uint32_t *scatter)
{
    size_t first = 0, row = 0;
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_RAY]; i++) {
        const size_t n_segment = portion->ray.segment_count[i];
        const size_t end = row + portion->ray.registration_count[i];
        size_t at = 0;
        uint32_t sum[2] = {0, 0};
        const struct walked its = {portion, i, first};
        for (; row < end; row++) {
            size_t segment = portion->registration.segment[row];
            segment = segment < n_segment ? segment : n_segment;
            if (segment < at)
                at = sum[0] = sum[1] = 0;
            add_steps(order, &its, at, segment, &sum[0], &sum[1]);
            at = segment;
            ghost[row] = sum[0];
            scatter[row] = sum[1];
        }
        first += n_segment;
    }
}
