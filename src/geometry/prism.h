/* SPDX-License-Identifier: MIT
 *
 * Straight prisms over a polygon as closed meshes.
 */
#ifndef RMAP_PRISM_H
#define RMAP_PRISM_H

#include "geometry/mesh.h"

#define RMAP_PRISM_SIDES_MAX 1000

/* From z = 0 to z = length over a polygon of n corners in any sense, 3 to RMAP_PRISM_SIDES_MAX,
 * which may be concave but not cross itself. Faces, wound outward: 0 the bottom, 1 the top, 2 + k
 * the side from corner k to the next in the order given. RMAP_INPUT: no such polygon, or nothing
 * is left of it in single precision; RMAP_SYSTEM. */
enum rmap_status rmap_mesh_prism(const double (*corner)[2], size_t n, double length,
                                 struct rmap_mesh **mesh_ret, struct rmap_error *err) RMAP_MUST_USE;

#endif
