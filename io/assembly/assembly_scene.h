/* SPDX-License-Identifier: MIT
 *
 * An assembly as the text of a scene, in three files: parts.yaml, which is made anew from each
 * revision of the model; scene.yaml and attributes.yaml, which are the user's.
 */
#ifndef RMAP_ASSEMBLY_SCENE_H
#define RMAP_ASSEMBLY_SCENE_H

#include <stdio.h>

#include "io/assembly/assembly.h"

#define RMAP_ASSEMBLY_MESHES     "meshes"
#define RMAP_ASSEMBLY_PARTS      "parts.yaml"
#define RMAP_ASSEMBLY_ATTRIBUTES "attributes.yaml"

/* Its labels are settled, and its shapes have files. context: the assembly. */
enum rmap_status rmap_assembly_put_parts(const void *context, FILE *out, struct rmap_error *err);
enum rmap_status rmap_assembly_put_attributes(const void *context, FILE *out,
                                              struct rmap_error *err);
enum rmap_status rmap_assembly_put_scene(const void *context, FILE *out, struct rmap_error *err);

/* The box about all parts, in the world; false: there is none. */
bool rmap_assembly_bounds(const struct rmap_assembly *assembly, struct rmap_vec3 *lower,
                          struct rmap_vec3 *upper);

#endif
