/* SPDX-License-Identifier: MIT
 *
 * The point where a leg meets the surface that its path names. The steps are the tracer's, so
 * that the doubles come out the same; but they are part of the format, and stay as they are when
 * the tracer's change.
 */
#include "compact/model.h"
#include "formula/triangle.h"

/* In the object's frame. */
struct local {
    struct rmap_vec3 origin, direction, point, normal;
    double t;
};

static void flat(struct local *l)
{
    l->t = -l->origin.z / l->direction.z;
    l->point =
        rmap_vec3(l->origin.x + l->t * l->direction.x, l->origin.y + l->t * l->direction.y, 0);
    l->normal = rmap_vec3(0, 0, 1);
}

/* own: the leg starts on it. */
static bool meet_quadric(const struct rmap_compact_object *o, bool own, double behind,
                         struct local *l)
{
    if (own) {
        l->t = rmap_quadric_other(&o->quadric.form, l->origin, l->direction);
        l->point = rmap_axpy(l->t, l->direction, l->origin);
        return true;
    }
    const struct rmap_quadric_roots roots =
        rmap_quadric_meet(&o->quadric.form, l->origin, l->direction);
    l->t = rmap_quadric_choose(&o->quadric, behind, &roots, l->direction, &l->point);
    return roots.missed == 0.0;
}

/* Newton's method on z - sag(x^2 + y^2) along the leg, from the conic's point on. */
#define ASPHERE_STEPS 8

static void descend_asphere(const struct rmap_shape *shape, struct local *l)
{
    double c = shape->curvature, t = l->t, slope = 0;
    for (int k = 0; k < ASPHERE_STEPS; k++) {
        struct rmap_vec3 p = rmap_axpy(t, l->direction, l->origin);
        double s = p.x * p.x + p.y * p.y, rest = 1 - (1 + shape->conic) * c * c * s;
        double root = sqrt(rest > 0 ? rest : 0), poly = 0, rate = 0;
        for (int i = shape->n_asphere - 1; i >= 0; i--) {
            poly = (poly + shape->asphere[i]) * s;
            rate = rate * s + (i + 1) * shape->asphere[i];
        }
        slope = root > 0 ? c / (2 * root) + rate : rate;
        double g = p.z - (c * s / (1 + root) + poly);
        double g_rate = l->direction.z - 2 * slope * (p.x * l->direction.x + p.y * l->direction.y);
        l->point = p;
        l->t = t;
        if (k + 1 < ASPHERE_STEPS && g_rate != 0)
            t -= g / g_rate;
    }
    l->normal = rmap_normalize(rmap_vec3(-2 * slope * l->point.x, -2 * slope * l->point.y, 1));
}

static bool meet_triangle(const struct rmap_compact_object *o, int32_t primitive, struct local *l)
{
    if (primitive < 0 || (size_t)primitive >= o->mesh->n_triangle)
        return false;
    struct rmap_vec3 corner[3];
    rmap_mesh_corners(o->mesh, (size_t)primitive, corner);
    l->t = rmap_triangle_meet(corner[0], corner[1], corner[2], l->origin, l->direction, &l->point,
                              &l->normal);
    return true;
}

bool rmap_facing_find(const struct rmap_compact_model *model, int32_t object, int32_t primitive,
                      int32_t from, struct rmap_vec3 origin, struct rmap_vec3 direction,
                      struct rmap_facing *facing)
{
    if (object < 0 || (size_t)object >= model->n_object)
        return false;
    const struct rmap_compact_object *o = &model->object[object];
    struct local l = {.origin = rmap_affine_point(&o->to_local, origin),
                      .direction = rmap_affine_vector(&o->to_local, direction)};
    bool own = from == object;
    switch (o->kind) {
    case RMAP_FACING_FLAT:
        flat(&l);
        break;
    case RMAP_FACING_QUADRIC:
        if (!meet_quadric(o, own, -model->epsilon, &l))
            return false;
        l.normal = rmap_quadric_unit_normal(&o->quadric, l.point);
        break;
    case RMAP_FACING_ASPHERE:
        if (!meet_quadric(o, own, -model->epsilon, &l))
            return false;
        descend_asphere(o->shape, &l);
        break;
    case RMAP_FACING_MESH:
        if (!meet_triangle(o, primitive, &l))
            return false;
        break;
    }
    facing->t = l.t > 0 ? l.t : 0;
    facing->position = rmap_affine_point(&o->to_world, l.point);
    facing->normal = rmap_affine_transposed(&o->to_local, l.normal);
    if (!o->rigid || o->kind == RMAP_FACING_MESH)
        facing->normal = rmap_normalize(facing->normal);
    return true;
}
