/* SPDX-License-Identifier: MIT
 *
 * Where objects stand, for who asks which rays pass there: boxes about all that the search for the
 * next surface looks at of them. Without Embree.
 */
#ifndef RMAP_ACCEL_PLACES_H
#define RMAP_ACCEL_PLACES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "base/vec.h"

struct rmap_scene;

/* A box in a frame of its own, and the one about it in the world. */
struct rmap_place {
    struct rmap_affine to_local;
    struct rmap_vec3 lower, upper, world_lower, world_upper;
};

/* Zeroed: none. */
struct rmap_places {
    struct rmap_place *place;
    size_t n, cap;
    struct rmap_vec3 lower, upper; /* about all, in the world */
};

/* mark: [n_object]; 1 is set for those that share a rim with a marked one, too: who of them is met
 * there is decided for all by one of them. RMAP_SYSTEM. */
enum rmap_status rmap_accel_mark_joined(const struct rmap_scene *scene, uint8_t *mark,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* Appends boxes about the marked objects: several about a tube or a ring, which leave its middle
 * out. RMAP_SYSTEM. */
enum rmap_status rmap_accel_add_places(const struct rmap_scene *scene, const uint8_t *mark,
                                       struct rmap_places *places,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Appends a box by hand, wider by `pad` in the world. RMAP_SYSTEM. */
enum rmap_status rmap_places_add(struct rmap_places *places, const struct rmap_affine *to_world,
                                 struct rmap_vec3 lower, struct rmap_vec3 upper, double pad,
                                 struct rmap_error *err) RMAP_MUST_USE;
void rmap_places_fini(struct rmap_places *places);

/* Whether the way from one point to another comes to one of them. */
bool rmap_places_meet(const struct rmap_places *places, struct rmap_vec3 from, struct rmap_vec3 to);

/* What points of a scene are rounded by where they are kept as floats, and more. */
double rmap_places_rounding(const struct rmap_scene *scene);

#endif
