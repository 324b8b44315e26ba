/* SPDX-License-Identifier: MIT
 *
 * Of which state of which file a mesh is, and how it was read: the next bundle of a scene that
 * lives takes it over from the one before.
 */
#ifndef RMAP_MESH_ORIGIN_H
#define RMAP_MESH_ORIGIN_H

#include "io/mesh/mesh_read.h"

struct rmap_mesh_origin;

/* To be made before the file is read. NULL: its state cannot be told, or memory is short. */
struct rmap_mesh_origin *rmap_mesh_origin_create(const char *path,
                                                 const struct rmap_mesh_reading *how);
void rmap_mesh_origin_destroy(struct rmap_mesh_origin *origin); /* NULL is fine */

/* A hold on the mesh of a bundle (NULL: there is none) that is of the same; NULL: it has none. */
struct rmap_mesh *rmap_mesh_again(const struct rmap_bundle *before,
                                  const struct rmap_mesh_origin *origin,
                                  struct rmap_mesh_left_out *left_out_ret);

/* The mesh that a bundle got last is of that origin, which is taken over. */
void rmap_mesh_origin_keep(struct rmap_bundle *bundle, struct rmap_mesh_origin *origin,
                           const struct rmap_mesh_left_out *left_out);

#endif
