/* SPDX-License-Identifier: MIT
 *
 * What the parts of the cells of objects (irradiance_cells.c, irradiance_shape.c, irradiance_uv.c)
 * share.
 */
#ifndef RMAP_IRRADIANCE_FACETS_H
#define RMAP_IRRADIANCE_FACETS_H

#include "analysis/detector/irradiance_cells.h"

/* Of the last part; its number of corners, area and triangle are given. */
enum rmap_status rmap_irradiance_add_facet(struct rmap_irradiance_cells *cells,
                                           const struct rmap_irradiance_facet *given,
                                           const struct rmap_vec3 *corner,
                                           struct rmap_error *err) RMAP_MUST_USE;

/* RMAP_USAGE, that they are more than there may be. */
enum rmap_status rmap_irradiance_too_many(const struct rmap_irradiance_cells *cells,
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

void rmap_irradiance_corners(const struct rmap_object *object, const struct rmap_mesh *mesh,
                             size_t triangle, struct rmap_vec3 corner[3]);
bool rmap_irradiance_has_face(const struct rmap_irradiance_choice *choice,
                              const struct rmap_mesh *mesh, size_t triangle);

/* The facets of the last part by texture coordinates, their `cell` a place in the texture;
 * RMAP_INPUT where the mesh has none (NULL: it is none). Then, of all parts, the cells by place. */
enum rmap_status rmap_irradiance_cut_uv(struct rmap_irradiance_cells *cells,
                                        const struct rmap_irradiance_choice *choice,
                                        const struct rmap_object *object,
                                        const struct rmap_mesh *mesh,
                                        struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_irradiance_index_uv(struct rmap_irradiance_cells *cells,
                                          struct rmap_error *err) RMAP_MUST_USE;
size_t rmap_irradiance_find_by_uv(const struct rmap_irradiance_cells *cells, size_t part,
                                  const struct rmap_mesh *mesh, size_t triangle,
                                  const double share[3]);

#endif
