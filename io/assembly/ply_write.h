/* SPDX-License-Identifier: MIT
 *
 * A mesh as a PLY file, with its faces.
 */
#ifndef RMAP_PLY_WRITE_H
#define RMAP_PLY_WRITE_H

#include "geometry/mesh.h"

/* Binary, in mm; triangles have the number of their face, comments the faces' names. */
enum rmap_status rmap_ply_write(const struct rmap_mesh *mesh, const char *path,
                                struct rmap_error *err) RMAP_MUST_USE;

#endif
