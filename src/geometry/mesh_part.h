/* SPDX-License-Identifier: MIT
 *
 * Some faces of a mesh as a mesh of their own, in the same frame: corners are the same to the bit,
 * so that the parts of a mesh have no holes between them, as it has none.
 */
#ifndef RMAP_MESH_PART_H
#define RMAP_MESH_PART_H

#include "geometry/mesh.h"

/* The faces that are marked, numbered anew in their order, with their names. wanted: [n_face].
 * RMAP_SYSTEM when memory is short. */
enum rmap_status rmap_mesh_part(const struct rmap_mesh *mesh, const uint8_t *wanted,
                                struct rmap_mesh **part_ret, struct rmap_error *err) RMAP_MUST_USE;

#endif
