/* SPDX-License-Identifier: MIT
 *
 * An axis-aligned box about what is put into it.
 */
#include "scene/bounds.h"

#include <math.h>

struct rmap_bounds rmap_bounds_empty(void)
{
    return (struct rmap_bounds){
        {HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}, false};
}

void rmap_bounds_include(struct rmap_bounds *box, struct rmap_vec3 p)
{
    if (!isfinite(p.x + p.y + p.z))
        box->infinite = true;
    box->lower = rmap_least(box->lower, p);
    box->upper = rmap_greatest(box->upper, p);
}

void rmap_bounds_include_box(struct rmap_bounds *box, const struct rmap_affine *to_world,
                             struct rmap_vec3 lower, struct rmap_vec3 upper)
{
    for (int k = 0; k < 8; k++)
        rmap_bounds_include(box, rmap_affine_point(to_world, rmap_vec3(k & 1 ? upper.x : lower.x,
                                                                       k & 2 ? upper.y : lower.y,
                                                                       k & 4 ? upper.z : lower.z)));
}

/* As rmap_bounds_include, without calls: scenes are opened for every question, and have many
 * vertices. What is not a number changes no bound. */
static inline void include_quickly(struct rmap_bounds *box, struct rmap_vec3 p)
{
    box->infinite |= !isfinite(p.x + p.y + p.z);
    box->lower =
        rmap_vec3(p.x < box->lower.x ? p.x : box->lower.x, p.y < box->lower.y ? p.y : box->lower.y,
                  p.z < box->lower.z ? p.z : box->lower.z);
    box->upper =
        rmap_vec3(p.x > box->upper.x ? p.x : box->upper.x, p.y > box->upper.y ? p.y : box->upper.y,
                  p.z > box->upper.z ? p.z : box->upper.z);
}

void rmap_bounds_include_geometry(struct rmap_bounds *box, const struct rmap_geometry *geometry,
                                  const struct rmap_affine *to_world)
{
    if (geometry->kind == RMAP_GEOMETRY_SHAPE) {
        struct rmap_vec3 lower, upper;
        rmap_shape_bounds(&geometry->shape, &lower, &upper);
        rmap_bounds_include_box(box, to_world, lower, upper);
        return;
    }
    const struct rmap_mesh *mesh = geometry->mesh;
    if (mesh->surface) {
        struct rmap_vec3 lower, upper;
        rmap_mesh_bounds(mesh, &lower, &upper);
        rmap_bounds_include_box(box, to_world, lower, upper);
        return;
    }
    for (size_t i = 0; i < mesh->n_vertex; i++) {
        const float *v = mesh->vertex[i];
        include_quickly(
            box, rmap_affine_point(to_world, rmap_vec3((double)v[0], (double)v[1], (double)v[2])));
    }
}

void rmap_bounds_include_detector(struct rmap_bounds *box, const struct rmap_detector *detector)
{
    if (detector->type != RMAP_DETECTOR_PLANE)
        return;
    for (int k = 0; k < 4; k++) {
        double u = (k & 1 ? 0.5 : -0.5) * detector->size[0];
        double v = (k & 2 ? 0.5 : -0.5) * detector->size[1];
        rmap_bounds_include(box,
                            rmap_axpy(u, detector->x, rmap_axpy(v, detector->y, detector->origin)));
    }
}
