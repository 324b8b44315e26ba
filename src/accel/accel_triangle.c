/* SPDX-License-Identifier: MIT
 *
 * Does the ray cross this triangle? Decided in double so that a mesh has no holes: the corners
 * are sheared into a plane in which the ray is the origin (Woop, Benthin and Wald 2013, JCGT
 * 2(1), "Watertight ray/triangle intersection"); each corner is rounded once, whatever triangle
 * it is looked at for, and on which side of an edge the origin lies is then exact. Triangles
 * that share an edge or a corner therefore agree, and the next surface does not depend on the
 * instruction set that Embree uses.
 */
#include "accel/accel_triangle.h"
#include "accel/accel_cell.h"
#include "accel/accel_internal.h"
#include "accel/accel_start.h"
#include "geometry/shape_solve.h"

/* Candidates for the next surface. Embree proposes; what counts is the distance worked out in
 * double, whether the surface really lies ahead of the start, and, among surfaces that coincide
 * within the rounding of their numbers, the one whose near side is the medium that the ray is
 * in, then the smallest (object, primitive). */

static enum rmap_rank candidate_rank(const struct rmap_query *query, int32_t object, double facing)
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

static struct rmap_vec3 candidate_normal(const struct rmap_query *query,
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
    struct rmap_vec3 sine = rmap_cross(candidate_normal(query, a), candidate_normal(query, b));
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
static bool candidate_add(struct rmap_query *query, const struct rmap_candidate *candidate)
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
    candidate->predicted = false;
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
                                           .predicted = hit.predicted && !joints.overruled,
                                           .rank = candidate_rank(query, object, facing)};
        if (own || (passed && hit.t > 0) ||
            shape_counts(query, &candidate, facing, length, tolerance))
            return candidate_add(query, &candidate);
        passed = o->rims && candidate.touches;
        from = rmap_greater(hit.t, 0);
    }
    return false;
}

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
    int side[3];  /* of the edge from corner k on */
    bool crosses; /* edges belong to both of their triangles; not one that is seen edge on */
};

static void pass(const struct rmap_local_ray *local, const float corner[9], struct passage *to)
{
    for (int k = 0; k < 3; k++)
        shear(local, &corner[3 * k], to->p[k]);
    int s0 = side(to->p[1], to->p[2], &to->area[0]);
    int s1 = side(to->p[2], to->p[0], &to->area[1]);
    int s2 = side(to->p[0], to->p[1], &to->area[2]);
    to->side[0] = s2;
    to->side[1] = s0;
    to->side[2] = s1;
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
    candidate->predicted = false; /* nor may it be the triangle that is listed */
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
    candidate->touches = candidate->on_true = false;
    set_crossing(&query->local, passage, candidate);
    rmap_facets_corners(o->facets, candidate->primitive, corner);
    struct rmap_vec3 n = rmap_cross(rmap_sub(corner[1], corner[0]), rmap_sub(corner[2], corner[0]));
    double facing = rmap_dot(n, query->local.direction);
    candidate->normal = rmap_affine_transposed(&o->to_local, n);
    candidate->length = rmap_length(candidate->normal);
    candidate->listed = candidate->primitive;
    candidate->predicted = !(query->start.nudged && query->start.object == candidate->object);
    candidate->cosine = fabs(facing) / candidate->length;
    candidate->tolerance = rmap_along(o->tolerance, candidate->cosine);
    candidate->rank = candidate_rank(query, candidate->object, facing);
    return counts(query, candidate, corner[0], n) && candidate_add(query, candidate);
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

/* Meshes whose faces lie on true surfaces: accel_cell.h. */

/* A point of a true surface as the start sees it: behind, ahead, or touching. */
static bool cell_counts(struct rmap_query *query, struct rmap_candidate *candidate, double facing)
{
    const struct rmap_accel_object *o = &query->accel->object[candidate->object];
    double tolerance = o->tolerance + query->start.tolerance;
    if (query->start.object == candidate->object)
        return candidate->from_start > 0;
    if (fabs(candidate->t) * candidate->cosine > tolerance ||
        fabs(candidate->t) > RMAP_GRAZING_MAX * tolerance)
        return candidate->t > 0;
    struct rmap_touch touch = {
        .object = candidate->object,
        .primitive = candidate->primitive,
        .rank = candidate->rank,
        .t = candidate->t,
        .facing = facing,
        .normal = rmap_scale(candidate->normal, 1 / candidate->length),
        .point = rmap_affine_point(&o->to_world, candidate->point),
    };
    candidate->touches = true;
    candidate->predicted = false;
    candidate->t = rmap_greater(candidate->t, 0);
    bool meets = rmap_start_meets(query, &touch);
    candidate->listed = touch.primitive;
    return meets;
}

static const struct rmap_true_meeting *meet_surface(struct rmap_query *query, int32_t object,
                                                    int32_t primitive)
{
    const struct rmap_cells *cells = query->accel->object[object].cells;
    int32_t surface = cells->its[primitive];
    const int slot = surface % RMAP_MET_SLOTS;
    struct rmap_true_meeting *at = &query->met[slot].at;
    if (query->met[slot].object == object && query->met[slot].surface == surface)
        return at;
    query->met[slot].object = object;
    query->met[slot].surface = surface;
    bool own = query->start.object == object && query->start.surface == surface;
    rmap_true_meet(&cells->surface[surface], query->local.origin, query->local.direction, own, at);
    return at;
}

/* Root i of those. */
static bool consider_root(struct rmap_query *query, int32_t object, int32_t primitive,
                          const struct rmap_true_meeting *met, int i)
{
    const struct rmap_accel_object *o = &query->accel->object[object];
    struct rmap_vec3 corner[3];
    rmap_facets_corners(o->facets, primitive, corner);
    struct rmap_vec3 flat =
        rmap_cross(rmap_sub(corner[1], corner[0]), rmap_sub(corner[2], corner[0]));
    struct rmap_vec3 n =
        rmap_true_normal(rmap_cell_surface(o->cells, primitive), met->point[i], flat);
    if (rmap_cell_is_start(query, object, primitive, met->point[i], n))
        return false;
    double facing = rmap_dot(n, query->local.direction);
    struct rmap_vec3 normal = rmap_affine_transposed(&o->to_local, n);
    double length = rmap_length(normal);
    struct rmap_vec3 middle =
        rmap_scale(rmap_add(corner[0], rmap_add(corner[1], corner[2])), 1.0 / 3);
    struct rmap_candidate candidate = {.t = met->t[i] - query->local.ahead,
                                       .from_start = met->t[i],
                                       .cosine = fabs(facing) / length,
                                       .tolerance = rmap_along(o->tolerance, fabs(facing) / length),
                                       .point = met->point[i],
                                       .normal = normal,
                                       .length = length,
                                       .object = object,
                                       .primitive = primitive,
                                       .listed = primitive,
                                       .on_true = true,
                                       .predicted =
                                           rmap_true_choose(met, query->accel->behind, middle) == i,
                                       .rank = candidate_rank(query, object, facing)};
    return cell_counts(query, &candidate, facing) && candidate_add(query, &candidate);
}

static bool consider_cell(struct rmap_query *query, int32_t object, int32_t primitive)
{
    const struct rmap_accel_object *o = &query->accel->object[object];
    const double grazing = RMAP_GRAZING_MAX * (o->tolerance + query->start.tolerance);
    const struct rmap_true_meeting *met = meet_surface(query, object, primitive);
    bool nearer = false;
    for (int i = 0; i < met->n; i++)
        if (met->t[i] >= -grazing && met->t[i] <= query->limit + grazing &&
            rmap_cell_holds(query, object, primitive, met->t[i], met->point[i]) &&
            consider_root(query, object, primitive, met, i))
            nearer = true;
    return nearer;
}

/* A triangle that is all there is, in such a mesh: at plain neighbours it ends where they begin. */
static bool consider_plain(struct rmap_query *query, int32_t object, int32_t primitive)
{
    const struct rmap_accel_object *o = &query->accel->object[object];
    struct rmap_candidate at;
    struct rmap_vec3 corner[3];
    struct passage passage;
    pass(&query->local, o->facets->corner[primitive], &passage);
    if (passage.sum == 0)
        return false;
    for (int k = 0; k < 3; k++)
        if (o->cells->edge[primitive][k].brink == RMAP_BRINK_FLAT &&
            passage.side[k] * passage.sum < 0)
            return false;
    set_crossing(&query->local, &passage, &at);
    rmap_facets_corners(o->facets, primitive, corner);
    at.point = rmap_axpy(at.point.z, rmap_sub(corner[2], corner[0]),
                         rmap_axpy(at.point.y, rmap_sub(corner[1], corner[0]), corner[0]));
    return rmap_cell_holds(query, object, primitive, at.t + query->local.ahead, at.point) &&
           consider(query, object, primitive, &passage);
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
            if (o->cells && other != primitive) {
                nearer |= rmap_consider_triangle(query, object, other);
                continue;
            }
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
    const struct rmap_accel_object *o = &query->accel->object[object];
    if (o->cells && rmap_cell_is_true(o->cells, primitive)) {
        rmap_query_local(query, object);
        return consider_cell(query, object, primitive);
    }
    if (is_start(query, object, primitive))
        return false;
    rmap_query_local(query, object);
    if (o->cells)
        return consider_plain(query, object, primitive);
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
