/* SPDX-License-Identifier: MIT
 *
 * What the parts of the cells of objects (irradiance_cells.c, irradiance_shape.c) share.
 */
#ifndef RMAP_IRRADIANCE_FACETS_H
#define RMAP_IRRADIANCE_FACETS_H

#include "analysis/detector/irradiance_cells.h"

/* Of the last part; its number of corners, area and triangle are given. */
enum rmap_status rmap_irradiance_add_facet(struct rmap_irradiance_cells *cells,
                                           const struct rmap_irradiance_facet *given,
                                           const struct rmap_vec3 *corner,
                                           struct rmap_error *err) RMAP_MUST_USE;

/* The facets of the last part, an object with this shape; and that at a place of it. */
enum rmap_status rmap_irradiance_cut_shape(struct rmap_irradiance_cells *cells,
                                           const struct rmap_object *object,
                                           const struct rmap_shape *shape,
                                           struct rmap_error *err) RMAP_MUST_USE;
size_t rmap_irradiance_find_on_shape(const struct rmap_irradiance_cells *cells,
                                     const struct rmap_irradiance_part *part,
                                     const struct rmap_object *object,
                                     const struct rmap_shape *shape, struct rmap_vec3 place);

#endif
