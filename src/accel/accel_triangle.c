/* SPDX-License-Identifier: MIT
 *
 * Does the ray cross this triangle? Decided in double so that a mesh has no holes: the corners
 * are sheared into a plane in which the ray is the origin (Woop, Benthin and Wald 2013, JCGT
 * 2(1), "Watertight ray/triangle intersection"); each corner is rounded once, whatever triangle
 * it is looked at for, and on which side of an edge the origin lies is then exact. Triangles
 * that share an edge or a corner therefore agree, and the next surface does not depend on the
 * instruction set that Embree uses.
 */
#include "accel/accel_internal.h"

/* In units of the float error; the sheared plane stretches distances by up to sqrt(3). */
#define EDGE_ERRORS 2

static double component(struct rmap_vec3 v, int axis)
{
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

static void set_shear(struct rmap_query *query)
{
    struct rmap_local_ray *local = &query->local;
    struct rmap_vec3 d = local->direction, from = local->origin;
    if (query->start.nudged && query->start.object == local->object) {
        from = query->start.inside;
        local->ahead = rmap_dot(rmap_sub(from, local->origin), d) / rmap_dot(d, d);
    }
    int z = fabs(d.x) > fabs(d.y) ? 0 : 1;
    if (fabs(d.z) > fabs(component(d, z)))
        z = 2;
    for (int k = 0; k < 3; k++) {
        local->axis[k] = (z + 1 + k) % 3;
        local->line[k] = component(from, local->axis[k]);
    }
    local->shear[2] = 1 / component(d, z);
    local->shear[0] = component(d, local->axis[0]) * local->shear[2];
    local->shear[1] = component(d, local->axis[1]) * local->shear[2];
}

void rmap_query_enter(struct rmap_query *query, int32_t object)
{
    struct rmap_local_ray *local = &query->local;
    const struct rmap_accel_object *o = &query->accel->object[object];
    local->object = object;
    local->origin = rmap_affine_point(&o->to_local, query->ray->origin);
    local->direction = rmap_affine_vector(&o->to_local, query->ray->direction);
    local->ahead = 0;
    if (o->mesh)
        set_shear(query);
}

/* A corner in the sheared frame: the plane's two coordinates, and along the axis. */
static void shear(const struct rmap_local_ray *local, const float *vertex, double p[3])
{
    p[2] = (double)vertex[local->axis[2]] - local->line[2];
    p[0] = ((double)vertex[local->axis[0]] - local->line[0]) - local->shear[0] * p[2];
    p[1] = ((double)vertex[local->axis[1]] - local->line[1]) - local->shear[1] * p[2];
}

/* Twice the area of (origin, a, b), and its exact sign: rounding keeps the order of products that
 * differ, and what it took from equal ones decides between those. */
static int side(const double a[3], const double b[3], double *area)
{
    double p = a[0] * b[1], q = a[1] * b[0];
    *area = p - q;
    if (p != q)
        return p > q ? 1 : -1;
    double r = fma(a[0], b[1], -p), s = fma(a[1], b[0], -q);
    return r > s ? 1 : r < s ? -1 : 0;
}

static double square_distance(const double a[3], const double b[3])
{
    return (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]);
}

/* What a line makes of a triangle. */
struct passage {
    double p[3][3]; /* corners in the sheared frame */
    double area[3], sum;
    bool crosses; /* edges belong to both of their triangles; not one that is seen edge on */
};

static void pass(const struct rmap_local_ray *local, const float corner[9], struct passage *to)
{
    for (int k = 0; k < 3; k++)
        shear(local, &corner[3 * k], to->p[k]);
    int s0 = side(to->p[1], to->p[2], &to->area[0]);
    int s1 = side(to->p[2], to->p[0], &to->area[1]);
    int s2 = side(to->p[0], to->p[1], &to->area[2]);
    to->sum = to->area[0] + to->area[1] + to->area[2];
    to->crosses = s0 * s1 >= 0 && s0 * s2 >= 0 && s1 * s2 >= 0 && to->sum != 0;
}

/* Where it does. */
static void set_crossing(const struct rmap_local_ray *local, const struct passage *at,
                         struct rmap_candidate *candidate)
{
    double sum = at->sum;
    candidate->point = rmap_vec3(at->area[0] / sum, at->area[1] / sum, at->area[2] / sum);
    candidate->t = (candidate->point.x * at->p[0][2] + candidate->point.y * at->p[1][2] +
                    candidate->point.z * at->p[2][2]) *
                   local->shear[2];
}

/* Does the line pass within `margin`, across it, of one of the triangle's edges? */
static bool nears_edge(const struct passage *at, double margin)
{
    const double(*p)[3] = at->p, *area = at->area;
    double least = rmap_lesser(fabs(area[0]), rmap_lesser(fabs(area[1]), fabs(area[2])));
    double longest =
        rmap_greater(square_distance(p[0], p[1]),
                     rmap_greater(square_distance(p[1], p[2]), square_distance(p[2], p[0])));
    return least * least <= margin * margin * longest;
}

/* The triangle as the start sees it: behind, ahead, or touching. */
static bool counts(struct rmap_query *query, struct rmap_candidate *candidate,
                   struct rmap_vec3 corner, struct rmap_vec3 n)
{
    const struct rmap_accel_object *o = &query->accel->object[candidate->object];
    bool own = query->start.object == candidate->object;
    double tolerance = own ? o->exact : o->tolerance + query->start.tolerance;
    double height = rmap_dot(n, rmap_sub(corner, query->local.origin));
    double t = candidate->t;
    if (fabs(height) > tolerance * candidate->length || fabs(t) > RMAP_GRAZING_MAX * tolerance)
        return t > 0;
    struct rmap_touch touch = {
        .object = candidate->object,
        .primitive = candidate->primitive,
        .rank = candidate->rank,
        .t = t,
        .facing = rmap_dot(n, query->local.direction),
        .normal = rmap_scale(candidate->normal, 1 / candidate->length),
        .point = rmap_affine_point(&o->to_world, corner),
    };
    candidate->touches = true;
    candidate->foretold = false; /* nor may it be the triangle that is listed */
    candidate->t = rmap_greater(t, 0);
    bool meets = rmap_start_meets(query, &touch);
    candidate->listed = touch.primitive;
    return meets;
}

/* A triangle that the line crosses. */
static bool consider(struct rmap_query *query, int32_t object, int32_t primitive,
                     const struct passage *passage)
{
    const struct rmap_accel_object *o = &query->accel->object[object];
    struct rmap_candidate own, *candidate = &own;
    struct rmap_vec3 corner[3];
    candidate->object = object;
    candidate->primitive = primitive;
    candidate->touches = false;
    set_crossing(&query->local, passage, candidate);
    rmap_facets_corners(o->facets, candidate->primitive, corner);
    struct rmap_vec3 n = rmap_cross(rmap_sub(corner[1], corner[0]), rmap_sub(corner[2], corner[0]));
    double facing = rmap_dot(n, query->local.direction);
    candidate->normal = rmap_affine_transposed(&o->to_local, n);
    candidate->length = rmap_length(candidate->normal);
    candidate->listed = candidate->primitive;
    candidate->foretold = !(query->start.nudged && query->start.object == candidate->object);
    candidate->cosine = fabs(facing) / candidate->length;
    candidate->tolerance = rmap_along(o->tolerance, candidate->cosine);
    candidate->rank = rmap_candidate_rank(query, candidate->object, facing);
    return counts(query, candidate, corner[0], n) && rmap_candidate_add(query, candidate);
}

static bool is_start(const struct rmap_query *query, int32_t object, int32_t primitive)
{
    return object == query->start.object && primitive == query->start.primitive;
}

/* Does the ray see the triangle so well that Embree cannot miss it? */
static bool stands_clear(const struct rmap_local_ray *local, const float sight[4], double square)
{
    struct rmap_vec3 n = rmap_vec3((double)sight[0], (double)sight[1], (double)sight[2]);
    double facing = rmap_dot(n, local->direction), cosine = (double)sight[3];
    return facing * facing > cosine * cosine * square;
}

bool rmap_consider_neighbours(struct rmap_query *query, int32_t object, int32_t primitive)
{
    const struct rmap_accel_object *o = &query->accel->object[object];
    const struct rmap_local_ray *local = &query->local;
    double square = rmap_dot(local->direction, local->direction);
    bool nearer = false;
    for (int k = 0; k < 3; k++) {
        uint32_t vertex = o->facets->same[o->mesh->triangle[primitive][k]];
        for (uint32_t i = o->facets->first[vertex]; i < o->facets->first[vertex + 1]; i++) {
            int32_t other = (int32_t)o->facets->fan[i];
            struct passage passage;
            if (other == primitive || is_start(query, object, other) ||
                stands_clear(local, o->facets->sight[other], square))
                continue;
            pass(local, o->facets->corner[other], &passage);
            if (passage.crosses && consider(query, object, other, &passage))
                nearer = true;
        }
    }
    return nearer;
}

bool rmap_consider_triangle(struct rmap_query *query, int32_t object, int32_t primitive)
{
    if (is_start(query, object, primitive))
        return false;
    rmap_query_local(query, object);
    const struct rmap_accel_object *o = &query->accel->object[object];
    const struct rmap_local_ray *local = &query->local;
    struct passage passage;
    pass(local, o->facets->corner[primitive], &passage);
    bool nearer = passage.crosses && consider(query, object, primitive, &passage);
    /* At an edge, or reported for its margin only, the ray crosses a neighbour too or instead,
     * which Embree misses where it is seen edge on, for a margin in its plane is none across
     * the ray. */
    if ((!passage.crosses || nears_edge(&passage, EDGE_ERRORS * o->local_error)) &&
        rmap_consider_neighbours(query, object, primitive))
        nearer = true;
    return nearer;
}
