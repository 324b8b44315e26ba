/* SPDX-License-Identifier: MIT
 *
 * Geometries: analytic shapes and meshes. Prescriptions are scene_lens.c.
 */
#ifndef RMAP_SCENE_GEOMETRIES_H
#define RMAP_SCENE_GEOMETRIES_H

#include "io/scene/scene_reader.h"

/* A file that the scene names, relative to the scene file's folder; arena. NULL: no memory. */
char *rmap_reader_path(struct rmap_reader *reader, const char *file);

/* The shape keys of a cap, shared by `conic` and the rows of a `lens`. */
bool rmap_reader_conic(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                       struct rmap_shape *shape);

/* A new geometry of the scene; *index_ret its index. The name is copied. */
void rmap_reader_add_shape(struct rmap_reader *reader, const char *name,
                           const struct rmap_shape *shape, int32_t *index_ret);

/* The same of a mesh, which is taken over; *index_ret stays where there is no memory. */
void rmap_reader_add_mesh(struct rmap_reader *reader, const char *name, struct rmap_mesh *mesh,
                          int32_t *index_ret);

void rmap_reader_read_geometries(struct rmap_reader *reader);

#endif
