/* SPDX-License-Identifier: MIT
 *
 * How often light was turned out of its way: the two orders by which stray light is counted.
 *
 * GHOST ORDER: number of specular reflections at surfaces that are not meant to reflect: those that
 * can let light through (dielectric interfaces, bare or coated; mixtures with a share of
 * transmission), and opaque ones that reflect less than half of it at every wavelength, at normal
 * incidence (a sensor). Neither a mirror's reflection nor a total internal one counts. Of an object
 * with two different sides the one that light met says so.
 * SCATTER ORDER: number of diffuse reflections, diffuse transmissions and volume scatterings.
 *
 * Of a ray: over its whole history. Of a registration: over the steps before the segment on which
 * the detector was reached; what happens at the object on which a detector lies comes after it.
 */
#ifndef RMAP_PATH_ORDER_H
#define RMAP_PATH_ORDER_H

#include "analysis/criterion/criterion_mark.h"
#include "analysis/criterion/criterion_tree.h"
#include "portion/event.h"
#include "portion/portion.h"
#include "scene/scene.h"

struct rmap_path_order {
    const struct rmap_scene *scene; /* borrowed */
    uint8_t *makes_ghosts; /* [n_object] bit 0: a specular reflection at its front does; bit 1: at
                              its back. Both where the other side reflects none */
    size_t n_object;
    bool by_side;            /* some objects have one of these bits alone */
    rmap_column_set columns; /* that the functions below read */
};

enum rmap_status rmap_path_order_init(struct rmap_path_order *order, const struct rmap_scene *scene,
                                      struct rmap_error *err) RMAP_MUST_USE;
void rmap_path_order_fini(struct rmap_path_order *order);

/* Events that count, the former at objects that make ghosts. */
#define RMAP_PATH_GHOST_EVENTS ((uint32_t)RMAP_EVENT_REFLECT_SPECULAR)
#define RMAP_PATH_SCATTER_EVENTS                                                                   \
    ((uint32_t)(RMAP_EVENT_REFLECT_DIFFUSE | RMAP_EVENT_TRANSMIT_DIFFUSE |                         \
                RMAP_EVENT_SCATTER_VOLUME))

/* What one step adds, 0 or 1. ray: row of /ray, whose segments begin at ray_row. */
static inline uint32_t rmap_path_ghost_step(const struct rmap_path_order *order,
                                            const struct rmap_portion *portion, size_t row,
                                            size_t ray, size_t ray_row)
{
    const int32_t object = portion->segment.object[row];
    if (!(portion->segment.event[row] & RMAP_PATH_GHOST_EVENTS) ||
        (size_t)(uint32_t)object >= order->n_object)
        return 0;
    const uint8_t side = order->makes_ghosts[object];
    if (side == 0 || side == 3)
        return side != 0;
    return (rmap_side_met(order->scene, portion, row, ray, ray_row) & side) != 0;
}

static inline uint32_t rmap_path_scatter_step(uint32_t events)
{
    return (events & RMAP_PATH_SCATTER_EVENTS) != 0;
}

/* Of all rays of a portion: [n_ray] each. */
void rmap_path_orders_of_rays(const struct rmap_path_order *order,
                              const struct rmap_portion *portion, uint32_t *ghost,
                              uint32_t *scatter);

/* Of all registrations, crossings that were not registered included: [n_registration] each. */
void rmap_path_orders_of_registrations(const struct rmap_path_order *order,
                                       const struct rmap_portion *portion, uint32_t *ghost,
                                       uint32_t *scatter);

#endif
