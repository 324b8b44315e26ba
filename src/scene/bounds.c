/* SPDX-License-Identifier: MIT
 *
 * An axis-aligned box about what is put into it.
 */
#include "scene/bounds.h"

#include <math.h>

#include "base/wide.h"

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

typedef double four __attribute__((vector_size(32)));
typedef int64_t four_masks __attribute__((vector_size(32)));

/* As rmap_bounds_include, x, y and z at a time: scenes are opened for every question, and have many
 * vertices. What is not a number changes no bound. */
RMAP_WIDE static void include_vertices(struct rmap_bounds *box, const struct rmap_mesh *mesh,
                                       const struct rmap_affine *to_world)
{
    const double(*m)[3] = to_world->m;
    const four column[3] = {{m[0][0], m[1][0], m[2][0]},
                            {m[0][1], m[1][1], m[2][1]},
                            {m[0][2], m[1][2], m[2][2]}},
               shift = {to_world->t.x, to_world->t.y, to_world->t.z};
    four lower = {box->lower.x, box->lower.y, box->lower.z},
         upper = {box->upper.x, box->upper.y, box->upper.z}, odd = {0.0};
    for (size_t i = 0; i < mesh->n_vertex; i++) {
        const float *v = mesh->vertex[i];
        const four p =
            column[0] * (double)v[0] + column[1] * (double)v[1] + column[2] * (double)v[2] + shift;
        const four_masks below = p<lower, above = p> upper;
        lower = (four)(((four_masks)p & below) | ((four_masks)lower & ~below));
        upper = (four)(((four_masks)p & above) | ((four_masks)upper & ~above));
        odd += p - p; /* NaN for infinite ones, too */
    }
    box->infinite |= isnan(odd[0] + odd[1] + odd[2]);
    box->lower = rmap_vec3(lower[0], lower[1], lower[2]);
    box->upper = rmap_vec3(upper[0], upper[1], upper[2]);
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
    include_vertices(box, mesh, to_world);
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
