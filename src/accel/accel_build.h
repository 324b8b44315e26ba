/* SPDX-License-Identifier: MIT
 *
 * Builds the two levels. Embree's world is the scene moved to the centre of its objects. A mesh
 * gets one bottom-level structure, shared by its instances. These are user primitives of the top
 * level, which take the ray into the mesh's frame in double, as analytic surfaces do: Embree's own
 * instances do it in float, whose error in a large scene is not small against a triangle.
 */
#ifndef RMAP_ACCEL_BUILD_H
#define RMAP_ACCEL_BUILD_H

#include "accel/accel_internal.h"

/* like: what it may take over; NULL: nothing. rmap_accel_rebuild: as rmap_accel_move; of no
 * object: the top level. */
enum rmap_status rmap_accel_build(struct rmap_accel *accel, const struct rmap_scene *scene,
                                  const struct rmap_accel *like,
                                  struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_accel_rebuild(struct rmap_accel *accel, const int32_t *object,
                                    size_t n_object, struct rmap_error *err) RMAP_MUST_USE;
void rmap_accel_release_top(struct rmap_accel *accel);
/* `whole`, unless it is there. */
enum rmap_status rmap_accel_build_whole(struct rmap_accel *accel,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* Object i as the scene has it, with its tolerances. */
void rmap_accel_set_object(struct rmap_accel *accel, const struct rmap_scene *scene, size_t i);

/* Boxes that together cover an object, in its frame: part in [0, rmap_part_count). */
int rmap_part_count(const struct rmap_accel_object *object);
void rmap_part_bounds(const struct rmap_accel_object *object, int part, struct rmap_vec3 *lower,
                      struct rmap_vec3 *upper);

/* A box becomes the one about it in the world. */
void rmap_world_box(const struct rmap_affine *to_world, struct rmap_vec3 *lower,
                    struct rmap_vec3 *upper);

/* Bounds in the world. */
void rmap_accel_bounds(const struct rmap_accel_object *object, struct rmap_vec3 *lower,
                       struct rmap_vec3 *upper);

/* Radii of the shell about a shape, from its axis. */
void rmap_shell_radii(const struct rmap_shape *shape, double radius[2]);

/* Float error of a mesh in its own frame: a rounding of its farthest coordinate. */
double rmap_mesh_rounding(struct rmap_vec3 lower, struct rmap_vec3 upper);

#endif
