/* SPDX-License-Identifier: MIT
 *
 * Candidates, decided in double. Embree proposes; what counts is the distance worked out here,
 * whether the surface really lies ahead of the start, and, among surfaces that coincide within
 * their float rounding, the one whose near side is the medium that the ray is in, then the
 * smallest (object, primitive).
 */
#include <math.h>

#include "geometry/accel_internal.h"

/* In units of the float error, to either side of it. */
#define GRAZE_ERRORS 4

void rmap_query_local(struct rmap_query *query, int32_t object)
{
    if (query->local_object == object)
        return;
    const struct rmap_affine *to_local = &query->accel->object[object].to_local;
    query->local_origin = rmap_affine_point(to_local, query->ray->origin);
    query->local_direction = rmap_affine_vector(to_local, query->ray->direction);
    query->local_object = object;
}

static double along(double distance, double cosine)
{
    return distance * fmin(1 / cosine, RMAP_GRAZING_MAX);
}

static int32_t rank_of(const struct rmap_query *query, int32_t object, double facing)
{
    const struct rmap_accel_object *o = &query->accel->object[object];
    int32_t near_medium = facing < 0 ? o->medium_front : o->medium_back;
    if (near_medium == RMAP_MEDIUM_ANY)
        return 1;
    return near_medium == query->ray->medium ? 0 : 2;
}

static bool before(const struct rmap_candidate *a, const struct rmap_candidate *b)
{
    if (a->rank != b->rank)
        return a->rank < b->rank;
    if (a->object != b->object)
        return a->object < b->object;
    return a->primitive < b->primitive;
}

const struct rmap_candidate *rmap_query_best(const struct rmap_query *query)
{
    const struct rmap_candidate *best = &query->candidate[0];
    for (int i = 1; i < query->n_candidate; i++)
        if (before(&query->candidate[i], best))
            best = &query->candidate[i];
    return best;
}

/* Keeps what overlaps [t - tolerance, limit], limit the least t + tolerance of all: a set that
 * does not depend on the order in which Embree finds them. */
static bool add(struct rmap_query *query, const struct rmap_candidate *candidate, double slack)
{
    if (candidate->t - candidate->tolerance > query->limit)
        return false;
    bool nearer = candidate->t + candidate->tolerance < query->limit;
    if (nearer) {
        query->limit = candidate->t + candidate->tolerance;
        query->slack = slack;
        int n = 0;
        for (int i = 0; i < query->n_candidate; i++)
            if (query->candidate[i].t - query->candidate[i].tolerance <= query->limit)
                query->candidate[n++] = query->candidate[i];
        query->n_candidate = n;
    }
    if (query->n_candidate < RMAP_CANDIDATE_MAX) {
        query->candidate[query->n_candidate++] = *candidate;
        return nearer;
    }
    struct rmap_candidate *worst = &query->candidate[0];
    for (int i = 1; i < query->n_candidate; i++)
        if (before(worst, &query->candidate[i]))
            worst = &query->candidate[i];
    if (before(candidate, worst))
        *worst = *candidate;
    return nearer;
}

/* Nearly edge on, the plane is met far from where the triangle is: its nearest point counts. */
static double edge_on(struct rmap_vec3 origin, struct rmap_vec3 direction, double t,
                      const struct rmap_vec3 corner[3])
{
    double scale = 1 / rmap_dot(direction, direction), low = INFINITY, high = -INFINITY;
    for (int k = 0; k < 3; k++) {
        double at = rmap_dot(rmap_sub(corner[k], origin), direction) * scale;
        low = fmin(low, at);
        high = fmax(high, at);
    }
    return fmin(fmax(t, low), high);
}

/* Does the point lie nearer than `margin` to an edge of the triangle, or beyond? Then the
 * neighbour may be the one. */
static bool beside(struct rmap_vec3 point, const struct rmap_vec3 corner[3], struct rmap_vec3 n,
                   double margin)
{
    double length = rmap_length(n);
    for (int k = 0; k < 3; k++) {
        struct rmap_vec3 a = corner[k], edge = rmap_sub(corner[(k + 1) % 3], a);
        if (rmap_dot(rmap_cross(edge, rmap_sub(point, a)), n) <=
            margin * length * rmap_length(edge))
            return true;
    }
    return false;
}

/* A ray past the silhouette of a closed body, within float error of its edge, may be reported to
 * leave it without having entered. It misses it. */
static bool grazes(const struct rmap_query *query, const struct rmap_candidate *candidate,
                   const struct rmap_vec3 corner[3], struct rmap_vec3 n, double cosine)
{
    const struct rmap_accel_object *o = &query->accel->object[candidate->object];
    return candidate->rank == 2 &&
           beside(rmap_axpy(candidate->t, query->local_direction, query->local_origin), corner, n,
                  along(GRAZE_ERRORS * o->local_error, cosine));
}

/* The triangle as the start sees it: behind, ahead, or touching. Sets t >= 0 when it counts. */
static bool counts(struct rmap_query *query, struct rmap_candidate *candidate, struct rmap_vec3 n,
                   const struct rmap_vec3 corner[3], double length)
{
    const struct rmap_accel_object *o = &query->accel->object[candidate->object];
    const struct rmap_start *start = &query->start;
    double facing = rmap_dot(n, query->local_direction);
    double height = rmap_dot(n, rmap_sub(corner[0], query->local_origin));
    bool own = start->object == candidate->object;
    double tolerance = own ? o->exact : o->tolerance + start->tolerance;
    double t = candidate->t;
    if (own && start->nudged)
        t = rmap_dot(n, rmap_sub(corner[0], start->inside_local)) / facing;
    if (fabs(height) <= tolerance * length) {
        struct rmap_touch touch = {
            .object = candidate->object,
            .primitive = candidate->primitive,
            .rank = candidate->rank,
            .t = t,
            .facing = facing,
            .normal = rmap_scale(rmap_affine_transposed(&o->to_local, n), 1 / length),
            .point = rmap_affine_point(&o->to_world, corner[0]),
            .beside = beside(query->local_origin, corner, n, 0),
        };
        candidate->t = 0;
        return rmap_start_meets(query, &touch);
    }
    candidate->t = fmax(candidate->t, 0);
    return t > 0;
}

bool rmap_consider_triangle(struct rmap_query *query, int32_t object, int32_t primitive)
{
    const struct rmap_accel_object *o = &query->accel->object[object];
    if (object == query->start.object && primitive == query->start.primitive)
        return false;
    rmap_query_local(query, object);
    struct rmap_vec3 corner[3];
    rmap_mesh_corners(o->mesh, (size_t)primitive, corner);
    struct rmap_vec3 n = rmap_cross(rmap_sub(corner[1], corner[0]), rmap_sub(corner[2], corner[0]));
    double facing = rmap_dot(n, query->local_direction);
    if (facing == 0)
        return false;
    double t = rmap_dot(n, rmap_sub(corner[0], query->local_origin)) / facing;
    double length = rmap_length(rmap_affine_transposed(&o->to_local, n));
    double cosine = fabs(facing) / length;
    if (cosine < 1e-4)
        t = edge_on(query->local_origin, query->local_direction, t, corner);
    struct rmap_candidate candidate = {.t = t,
                                       .tolerance = along(o->tolerance, cosine),
                                       .object = object,
                                       .primitive = primitive,
                                       .rank = rank_of(query, object, facing)};
    if (t - candidate.tolerance > query->limit || !counts(query, &candidate, n, corner, length) ||
        grazes(query, &candidate, corner, n, cosine))
        return false;
    return add(query, &candidate, query->accel->error + 2 * along(o->error, cosine));
}

/* A root of a shape that is not the one the ray starts from. near_t: roots this small may touch
 * the start. */
static bool shape_counts(struct rmap_query *query, struct rmap_candidate *candidate, double facing,
                         double length, double tolerance)
{
    double cosine = fabs(facing) / length;
    if (fabs(candidate->t) * cosine > tolerance)
        return candidate->t > 0;
    const struct rmap_accel_object *o = &query->accel->object[candidate->object];
    struct rmap_touch touch = {
        .object = candidate->object,
        .rank = candidate->rank,
        .t = candidate->t,
        .facing = facing,
        .normal = rmap_scale(rmap_affine_transposed(&o->to_local, candidate->normal), 1 / length),
        .point = rmap_affine_point(&o->to_world, candidate->point),
    };
    candidate->t = 0;
    return rmap_start_meets(query, &touch);
}

bool rmap_consider_shape(struct rmap_query *query, int32_t object)
{
    const struct rmap_accel_object *o = &query->accel->object[object];
    bool own = query->start.object == object;
    double tolerance = o->tolerance + query->start.tolerance;
    double from = own ? 0 : -RMAP_GRAZING_MAX * tolerance;
    double to = query->limit + RMAP_GRAZING_MAX * o->tolerance;
    rmap_query_local(query, object);
    /* roots that touch the start without counting are passed over: at most two, as a quadric
     * has no more and an asphere's others lie farther off */
    for (int i = 0; i < 3; i++) {
        struct rmap_shape_hit hit;
        if (!rmap_shape_intersect(o->shape, query->local_origin, query->local_direction, own, from,
                                  to, &hit))
            return false;
        double facing = rmap_dot(hit.normal, query->local_direction);
        double length = rmap_length(rmap_affine_transposed(&o->to_local, hit.normal));
        struct rmap_candidate candidate = {.t = hit.t,
                                           .tolerance = along(o->tolerance, fabs(facing) / length),
                                           .point = hit.point,
                                           .normal = hit.normal,
                                           .object = object,
                                           .rank = rank_of(query, object, facing)};
        if (own || shape_counts(query, &candidate, facing, length, tolerance))
            return add(query, &candidate, query->accel->error);
        from = fmax(hit.t, 0);
    }
    return false;
}
