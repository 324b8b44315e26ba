/* SPDX-License-Identifier: MIT
 *
 * Meshes as they were read before, in a folder that may be deleted at any time. A mesh's file and
 * how it is read name the file that keeps it, so that what a changed mesh leaves there is written
 * over; whether it is of the bytes that the mesh's file has now, of this program and undamaged says
 * what is in it:
 *
 *   head  struct head of mesh_cache.c
 *   body  a bundle of that mesh alone (bundle_pack.h)
 */
#ifndef RMAP_MESH_CACHE_H
#define RMAP_MESH_CACHE_H

#include "io/mesh/mesh_read.h"

/* Smaller files are read as fast as what is kept of them. */
#define RMAP_MESH_CACHE_LEAST ((size_t)64 << 10)

struct rmap_mesh_kept {
    char *path;      /* of the file that keeps it */
    uint64_t key[2]; /* of the bytes of the mesh's file, and of the program */
};

/* Of the bytes of the mesh's file at `path`. RMAP_SYSTEM. Zero-initialise, fini in any case. */
enum rmap_status rmap_mesh_kept_init(struct rmap_mesh_kept *kept, const char *path,
                                     const struct rmap_mesh_reading *how, const uint8_t *bytes,
                                     size_t nbytes, struct rmap_error *err) RMAP_MUST_USE;
void rmap_mesh_kept_fini(struct rmap_mesh_kept *kept);

/* *mesh_ret stays NULL where nothing is kept, or of another state of the mesh's file. RMAP_FORMAT:
 * what is there is damaged, or something else; RMAP_SYSTEM. */
enum rmap_status rmap_mesh_kept_read(const struct rmap_mesh_kept *kept, struct rmap_mesh **mesh_ret,
                                     struct rmap_mesh_left_out *left_out_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* In place of what is there; makes the folder. RMAP_USAGE, RMAP_SYSTEM: it cannot be written. */
enum rmap_status rmap_mesh_kept_write(const struct rmap_mesh_kept *kept, struct rmap_mesh *mesh,
                                      const struct rmap_mesh_left_out *left_out,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
