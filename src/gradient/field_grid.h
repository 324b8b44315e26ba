/* SPDX-License-Identifier: MIT
 *
 * A field given at the nodes of a grid.
 */
#ifndef RMAP_FIELD_GRID_H
#define RMAP_FIELD_GRID_H

#include "gradient/field.h"
#include "gradient/grid.h"

enum rmap_interpolation {
    RMAP_TRILINEAR, /* values and, apart, the central differences of the nodes: the gradient is
                       continuous, and of second order as the values are */
    RMAP_TRICUBIC   /* Catmull & Rom 1974 along each axis: C1, with its own exact gradient; exact
                       for quadratic fields, up to the faces of the grid */
};

/* Holds the grid. Outside of it, and where a hole takes part, there is no value; `outside`, unless
 * NaN, is the value outside of the grid (a step in the index unless the grid ends with it). */
enum rmap_status rmap_field_grid(struct rmap_field **field_ret, struct rmap_grid *grid,
                                 enum rmap_interpolation interpolation, double outside,
                                 struct rmap_error *err) RMAP_MUST_USE;

#endif
