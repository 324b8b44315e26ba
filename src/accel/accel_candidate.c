/* SPDX-License-Identifier: MIT
 *
 * Candidates for the next surface. Embree proposes; what counts is the distance worked out in
 * double, whether the surface really lies ahead of the start, and, among surfaces that coincide
 * within the rounding of their numbers, the one whose near side is the medium that the ray is
 * in, then the smallest (object, primitive).
 */
#include "accel/accel_internal.h"
#include "geometry/shape_solve.h"

enum rmap_rank rmap_candidate_rank(const struct rmap_query *query, int32_t object, double facing)
{
    const struct rmap_accel_object *o = &query->accel->object[object];
    int32_t near_medium = facing < 0 ? o->medium_front : o->medium_back;
    int32_t far_medium = facing < 0 ? o->medium_back : o->medium_front;
    if (near_medium == RMAP_MEDIUM_ANY)
        return RMAP_RANK_ANY;
    if (near_medium != query->ray->medium)
        return RMAP_RANK_OTHER;
    return far_medium == near_medium ? RMAP_RANK_WITHIN : RMAP_RANK_NEAR;
}

static bool before(const struct rmap_candidate *a, const struct rmap_candidate *b)
{
    if (a->rank != b->rank)
        return a->rank < b->rank;
    if (a->object != b->object)
        return a->object < b->object;
    return a->primitive < b->primitive;
}

struct rmap_vec3 rmap_candidate_normal(const struct rmap_query *query,
                                       const struct rmap_candidate *candidate)
{
    const struct rmap_accel_object *o = &query->accel->object[candidate->object];
    if (o->mesh)
        return rmap_scale(candidate->normal, 1 / candidate->length);
    return rmap_normalize(rmap_affine_transposed(&o->to_local, candidate->normal));
}

/* Do two surfaces coincide where the ray meets them? Parallel ones within the rounding of their
 * numbers; those that cross, where double rounding cannot tell which comes first. */
static bool coincide(const struct rmap_query *query, const struct rmap_candidate *a,
                     const struct rmap_candidate *b)
{
    const struct rmap_accel_object *object = query->accel->object;
    double gap = fabs(a->t - b->t) * rmap_greater(a->cosine, b->cosine);
    if (gap <= object[a->object].exact + object[b->object].exact)
        return true;
    if (a->object == b->object || gap > object[a->object].tolerance + object[b->object].tolerance)
        return false;
    struct rmap_vec3 sine =
        rmap_cross(rmap_candidate_normal(query, a), rmap_candidate_normal(query, b));
    return rmap_length(sine) <= RMAP_PARALLEL_OTHER;
}

const struct rmap_candidate *rmap_query_best(const struct rmap_query *query)
{
    const struct rmap_candidate *nearest = &query->candidate[0];
    for (int i = 1; i < query->n_candidate; i++)
        if (query->candidate[i].t < nearest->t)
            nearest = &query->candidate[i];
    const struct rmap_candidate *best = nearest;
    for (int i = 0; i < query->n_candidate; i++) {
        const struct rmap_candidate *other = &query->candidate[i];
        if (other != nearest && before(other, best) && coincide(query, other, nearest))
            best = other;
    }
    return best;
}

static bool farther(const struct rmap_candidate *a, const struct rmap_candidate *b)
{
    return a->t != b->t ? a->t > b->t : before(b, a);
}

/* Keeps what overlaps [t - tolerance, limit], limit the least t + tolerance of all: a set that
 * does not depend on the order in which Embree finds them. */
bool rmap_candidate_add(struct rmap_query *query, const struct rmap_candidate *candidate)
{
    if (candidate->t - candidate->tolerance > query->limit)
        return false;
    for (int i = 0; i < query->n_candidate; i++)
        if (query->candidate[i].object == candidate->object &&
            query->candidate[i].primitive == candidate->primitive)
            return false;
    bool nearer = candidate->t + candidate->tolerance < query->limit;
    if (nearer) {
        query->limit = candidate->t + candidate->tolerance;
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
    struct rmap_candidate *farthest = &query->candidate[0];
    for (int i = 1; i < query->n_candidate; i++)
        if (farther(&query->candidate[i], farthest))
            farthest = &query->candidate[i];
    if (farther(farthest, candidate))
        *farthest = *candidate;
    return nearer;
}

/* A root of a shape that is not the one the ray starts from. */
static bool shape_counts(struct rmap_query *query, struct rmap_candidate *candidate, double facing,
                         double length, double tolerance)
{
    double cosine = fabs(facing) / length;
    if (fabs(candidate->t) * cosine > tolerance ||
        fabs(candidate->t) > RMAP_GRAZING_MAX * tolerance)
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
    candidate->touches = true;
    candidate->foretold = false;
    candidate->t = rmap_greater(touch.t, 0);
    return rmap_start_meets(query, &touch);
}

bool rmap_consider_shape(struct rmap_query *query, int32_t object)
{
    if (query->done[object % RMAP_DONE_SLOTS] == object)
        return false;
    query->done[object % RMAP_DONE_SLOTS] = object;
    const struct rmap_accel_object *o = &query->accel->object[object];
    bool own = query->start.object == object;
    double tolerance = o->tolerance + query->start.tolerance;
    double from = own ? 0 : -RMAP_GRAZING_MAX * tolerance;
    double to = rmap_greater(query->limit, 0) + RMAP_GRAZING_MAX * tolerance;
    rmap_query_local(query, object);
    struct rmap_joints joints = {.query = query, .object = object};
    /* roots that touch the start without counting are passed over: at most two, as a quadric
     * has no more and an asphere's others lie farther off */
    bool passed = false; /* the root at a joint at which the ray starts: the next one counts */
    for (int i = 0; i < 3; i++) {
        struct rmap_shape_hit hit;
        const struct rmap_shape_query line = {
            query->local.origin,  query->local.direction,  own, from, to,
            query->accel->behind, o->rims ? &joints : NULL};
        if (!rmap_shape_solve(o->shape, &line, &hit))
            return false;
        double facing = rmap_dot(hit.normal, query->local.direction);
        double length = 1;
        if (!o->rigid)
            length = rmap_length(rmap_affine_transposed(&o->to_local, hit.normal));
        struct rmap_candidate candidate = {.t = hit.t,
                                           .cosine = fabs(facing) / length,
                                           .tolerance =
                                               rmap_along(o->tolerance, fabs(facing) / length),
                                           .point = hit.point,
                                           .normal = hit.normal,
                                           .object = object,
                                           .foretold = hit.foretold && !joints.overruled,
                                           .rank = rmap_candidate_rank(query, object, facing)};
        if (own || (passed && hit.t > 0) ||
            shape_counts(query, &candidate, facing, length, tolerance))
            return rmap_candidate_add(query, &candidate);
        passed = o->rims && candidate.touches;
        from = rmap_greater(hit.t, 0);
    }
    return false;
}
