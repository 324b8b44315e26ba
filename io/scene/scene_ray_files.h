/* SPDX-License-Identifier: MIT
 *
 * Sources whose rays stand in files.
 */
#ifndef RMAP_SCENE_RAY_FILES_H
#define RMAP_SCENE_RAY_FILES_H

#include "io/scene/scene_reader.h"
#include "io/scene/scene_source_light.h"

/* `type: ray_file`: place, rays and, where the scene is silent, flux. */
void rmap_reader_read_ray_file(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                               struct rmap_source *source, struct rmap_source_light *light);

/* The rows of `file`, of rays or of steps, by the bundle or, into it, from the file; NULL after a
 * complaint. Borrowed. */
struct rmap_file_rays *rmap_reader_file_rays(struct rmap_reader *reader,
                                             const struct rmap_yaml_node *node, bool steps);

#endif
