/* SPDX-License-Identifier: MIT
 *
 * How often light was turned out of its way: the two orders by which stray light is told.
 *
 * GHOST ORDER: number of specular reflections at surfaces that are not meant to reflect: those that
 * can let light through (dielectric interfaces, bare or coated; mixtures with a share of
 * transmission), and opaque ones that reflect less than half of it at every wavelength, at normal
 * incidence (a sensor). Neither a mirror's reflection nor a total internal one counts. An object
 * makes ghosts when either of its sides does.
 * SCATTER ORDER: number of diffuse reflections, diffuse transmissions and volume scatterings.
 *
 * Of a ray: over its whole history. Of a registration: over the steps before the leg on which the
 * detector was reached; what happens at the object on which a detector lies comes after it.
 */
#ifndef RMAP_PATH_ORDER_H
#define RMAP_PATH_ORDER_H

#include "scene/scene.h"
#include "trace/event.h"
#include "trace/portion.h"

struct rmap_path_order {
    uint8_t *makes_ghosts; /* [n_object] 1: a specular reflection there does */
    size_t n_object;
};

enum rmap_status rmap_path_order_init(struct rmap_path_order *order, const struct rmap_scene *scene,
                                      struct rmap_error *err) RMAP_MUST_USE;
void rmap_path_order_fini(struct rmap_path_order *order);

/* Events that count, the former at objects that make ghosts. */
#define RMAP_PATH_GHOST_EVENTS ((uint32_t)RMAP_EVENT_REFLECT_SPECULAR)
#define RMAP_PATH_SCATTER_EVENTS                                                                   \
    ((uint32_t)(RMAP_EVENT_REFLECT_DIFFUSE | RMAP_EVENT_TRANSMIT_DIFFUSE |                         \
                RMAP_EVENT_SCATTER_VOLUME))

/* What one step adds, 0 or 1. object: -1 for none. */
static inline uint32_t rmap_path_ghost_step(const struct rmap_path_order *order, int32_t object,
                                            uint32_t events)
{
    return events & RMAP_PATH_GHOST_EVENTS && (size_t)(uint32_t)object < order->n_object
               ? order->makes_ghosts[object]
               : 0;
}

static inline uint32_t rmap_path_scatter_step(uint32_t events)
{
    return (events & RMAP_PATH_SCATTER_EVENTS) != 0;
}

/* Columns that the functions below read. */
#define RMAP_PATH_ORDER_COLUMNS                                                                    \
    (RMAP_COLUMN_BIT(RMAP_RAY_segment_count) | RMAP_COLUMN_BIT(RMAP_RAY_registration_count) |      \
     RMAP_COLUMN_BIT(RMAP_SEGMENT_object) | RMAP_COLUMN_BIT(RMAP_SEGMENT_event) |                  \
     RMAP_COLUMN_BIT(RMAP_REGISTRATION_segment))

/* Of all rays of a portion: [n_ray] each. */
void rmap_path_orders_of_rays(const struct rmap_path_order *order,
                              const struct rmap_portion *portion, uint32_t *ghost,
                              uint32_t *scatter);

/* Of all registrations, crossings that were not registered included: [n_registration] each. */
void rmap_path_orders_of_registrations(const struct rmap_path_order *order,
                                       const struct rmap_portion *portion, uint32_t *ghost,
                                       uint32_t *scatter);

#endif
