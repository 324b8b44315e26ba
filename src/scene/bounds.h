/* SPDX-License-Identifier: MIT
 *
 * An axis-aligned box about what is put into it.
 */
#ifndef RMAP_BOUNDS_H
#define RMAP_BOUNDS_H

#include "scene/scene.h"

/* Empty while lower > upper. */
struct rmap_bounds {
    struct rmap_vec3 lower, upper;
    bool infinite; /* fmin and fmax would pass over a NaN */
};

struct rmap_bounds rmap_bounds_empty(void);
void rmap_bounds_include(struct rmap_bounds *box, struct rmap_vec3 p);

/* The eight corners of a local box, in the world. */
void rmap_bounds_include_box(struct rmap_bounds *box, const struct rmap_affine *to_world,
                             struct rmap_vec3 lower, struct rmap_vec3 upper);

/* A geometry's vertices, or the corners of its box. */
void rmap_bounds_include_geometry(struct rmap_bounds *box, const struct rmap_geometry *geometry,
                                  const struct rmap_affine *to_world);

/* Of one that lies somewhere. */
void rmap_bounds_include_detector(struct rmap_bounds *box, const struct rmap_detector *detector);

/* Parts of rmap_scene_finish. The inverse of an object's transform; RMAP_INPUT: there is none. */
enum rmap_status rmap_object_invert(struct rmap_object *object,
                                    struct rmap_error *err) RMAP_MUST_USE;
/* scene->object_bounds of all; of one, which they have room for. */
enum rmap_status rmap_scene_bound_objects(struct rmap_scene *scene,
                                          struct rmap_error *err) RMAP_MUST_USE;
void rmap_scene_bound_object(struct rmap_scene *scene, size_t i);
/* The bounding sphere about these, sources and detectors. */
enum rmap_status rmap_scene_bound(struct rmap_scene *scene, struct rmap_error *err) RMAP_MUST_USE;

#endif
