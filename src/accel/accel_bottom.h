/* SPDX-License-Identifier: MIT
 *
 * The lower level: of each mesh Embree's tree of its triangles and what queries need of these. It
 * does not depend on where objects stand, so that structures of scenes with the same meshes share
 * it.
 */
#ifndef RMAP_ACCEL_BOTTOM_H
#define RMAP_ACCEL_BOTTOM_H

#include "accel/accel_internal.h"

struct rmap_bottom {
    RTCScene scene;
    void *widened; /* triangles that the scene was built of; NULL: of cells */
    struct rmap_facets facets;
    struct rmap_mesh *mesh; /* held */
    struct rmap_vec3 lower, upper;
    int n_more; /* holders beside the first */
};

/* Of one mesh; *bottom_ret stays NULL where it has no triangles. Whatever the status:
 * rmap_bottom_release, which gives up one holder (NULL is fine). */
enum rmap_status rmap_bottom_create(struct rmap_accel *accel, const struct rmap_geometry *geometry,
                                    struct rmap_bottom **bottom_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;
void rmap_bottom_release(struct rmap_bottom *bottom);

/* Of all meshes that objects of the scene have; those that `like` (or NULL) has are taken over. */
enum rmap_status rmap_bottoms_build(struct rmap_accel *accel, const struct rmap_scene *scene,
                                    const struct rmap_accel *like,
                                    struct rmap_error *err) RMAP_MUST_USE;
void rmap_bottoms_release(struct rmap_accel *accel);

#endif
