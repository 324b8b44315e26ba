/* SPDX-License-Identifier: MIT
 *
 * A scene as solid bodies seen from outside: shaded faces, those of glass translucent, and visible
 * edges as lines. What encloses the scene on the eye's side (walls, a ceiling) is left out.
 */
#ifndef RMAP_FIGURE_SOLID_H
#define RMAP_FIGURE_SOLID_H

#include "analysis/detector/irradiance_cells.h"
#include "analysis/figure/figure_view.h"

/* Objects in colours of their cells, without shading. What stands before them is there as lines. */
struct rmap_painted {
    const struct rmap_irradiance_cells *cells;
    uint8_t (*rgb)[3];   /* [n_cell] sRGB */
    enum rmap_side side; /* FRONT, BACK: seen from there alone */
};

/* The bodies as one view shows them. mesh: [n_geometry], welded or tessellated; only for the call.
 * painted: NULL: none. */
struct rmap_solid;
enum rmap_status rmap_solid_create(const struct rmap_scene *scene, struct rmap_mesh *const *mesh,
                                   const struct rmap_painted *painted,
                                   const struct rmap_view_frame *frame,
                                   struct rmap_solid **solid_ret,
                                   struct rmap_error *err) RMAP_MUST_USE;
void rmap_solid_destroy(struct rmap_solid *solid); /* NULL is fine */

/* Puts them into the picture. */
enum rmap_status rmap_solid_draw(const struct rmap_solid *solid, struct rmap_svg *svg,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* Is a body that is not of glass in front of this point: pixel of the picture, and depth in view
 * coordinates? */
bool rmap_solid_hides(const struct rmap_solid *solid, double x, double y, double depth);

#endif
