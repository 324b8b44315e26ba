/* SPDX-License-Identifier: MIT
 *
 * Meshes as they were read before, kept as kept_file.h says. The body is a bundle of that mesh
 * alone (bundle_pack.h), behind what was left out of its file.
 */
#ifndef RMAP_MESH_CACHE_H
#define RMAP_MESH_CACHE_H

#include "io/file/kept_file.h"
#include "io/mesh/mesh_read.h"

/* Of the bytes of the mesh's file at `path`: rmap_kept_init. */
enum rmap_status rmap_mesh_kept_init(struct rmap_kept *kept, const char *path,
                                     const struct rmap_mesh_reading *how, const uint8_t *bytes,
                                     size_t nbytes, struct rmap_error *err) RMAP_MUST_USE;

/* *mesh_ret stays NULL where nothing is kept, or of another state of the mesh's file. RMAP_FORMAT:
 * what is there is damaged, or something else; RMAP_SYSTEM. */
enum rmap_status rmap_mesh_kept_read(const struct rmap_kept *kept, struct rmap_mesh **mesh_ret,
                                     struct rmap_mesh_left_out *left_out_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* In place of what is there; makes the folder. RMAP_USAGE, RMAP_SYSTEM: it cannot be written. */
enum rmap_status rmap_mesh_kept_write(const struct rmap_kept *kept, struct rmap_mesh *mesh,
                                      const struct rmap_mesh_left_out *left_out,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
