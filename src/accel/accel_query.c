/* SPDX-License-Identifier: MIT
 *
 * The next surface that a ray meets.
 */
#include <math.h>
#include <string.h>

#include "accel/accel.h"
#include "accel/accel_build.h"
#include "accel/accel_internal.h"
#include "accel/accel_prefilter.h"
#include "accel/accel_start.h"
#include "accel/accel_triangle.h"

/* The list of surfaces that coincide at the ray's start. Along the first direction, entries
 * [0, passed) lie behind and [passed, n) ahead; a surface that touches it belongs to the point, one
 * further on begins a new point. */

static bool is_entry(const struct rmap_contact *contact, int32_t k, const struct rmap_hit *hit)
{
    return k >= 0 && k < contact->n && contact->surface[k].object == hit->object &&
           contact->surface[k].primitive == hit->primitive;
}

/* Entry of the hit, put into the list where it is new. */
static int32_t enter(struct rmap_contact *contact, const struct rmap_hit *hit)
{
    int32_t k = contact->backward ? contact->passed - 1 : contact->passed;
    if (hit->t == 0 && is_entry(contact, k, hit))
        return k;
    if (hit->t > 0 || contact->backward) {
        contact->backward = false; /* a new point, or an edge met on the way back */
        k = 0;
    }
    if (k == RMAP_CONTACT_MAX) { /* forget the oldest */
        memmove(&contact->surface[0], &contact->surface[1],
                (RMAP_CONTACT_MAX - 1) * sizeof(contact->surface[0]));
        k--;
    }
    contact->surface[k].object = hit->object;
    contact->surface[k].primitive = hit->primitive;
    contact->n = k + 1;
    return k;
}

void rmap_contact_pass(struct rmap_contact *contact, const struct rmap_hit *hit)
{
    int32_t k = enter(contact, hit);
    contact->passed = contact->backward ? k : k + 1;
}

void rmap_contact_turn(struct rmap_contact *contact, const struct rmap_hit *hit)
{
    int32_t k = enter(contact, hit);
    contact->passed = contact->backward ? k + 1 : k;
    contact->backward = !contact->backward;
}

/* One query: the float ray for Embree, the callbacks in which the candidates are decided in
 * double, and the hit. */

static void traversal_init(struct rmap_traversal *traversal, struct rmap_query *query)
{
    rtcInitIntersectContext(&traversal->context);
    traversal->query = query;
    traversal->t_far = INFINITY;
    traversal->object = -1;
}

/* After the limit has shrunk: nothing beyond it and the float error of distances is worth a
 * look. */
static float shrink(struct rmap_traversal *traversal)
{
    const struct rmap_query *query = traversal->query;
    double slack = RMAP_SLACK_ERRORS * query->accel->error;
    double far = (query->limit + slack - traversal->shift) * traversal->rate;
    float t_far = (float)far; /* the slack is many roundings wide */
    if (t_far < traversal->t_far)
        traversal->t_far = t_far > 0 ? t_far : 0;
    return traversal->t_far;
}

void rmap_accel_triangle(const struct RTCFilterFunctionNArguments *args)
{
    /* one ray at a time: the N = 1 layouts are RTCRay and RTCHit */
    struct rmap_traversal *traversal = (struct rmap_traversal *)args->context;
    struct RTCRay *ray = (struct RTCRay *)args->ray;
    const struct RTCHit *hit = (const struct RTCHit *)args->hit;
    if (rmap_consider_triangle(traversal->query, traversal->object, (int32_t)hit->primID))
        ray->tfar = shrink(traversal);
    else
        args->valid[0] = 0;
}

void rmap_accel_cell(const struct RTCIntersectFunctionNArguments *args)
{
    struct rmap_traversal *traversal = (struct rmap_traversal *)args->context;
    if (args->valid[0] &&
        rmap_consider_triangle(traversal->query, traversal->object, (int32_t)args->primID))
        ((struct RTCRayHit *)args->rayhit)->ray.tfar = shrink(traversal);
}

static void search(struct rmap_traversal *traversal, RTCScene scene, const float origin[3],
                   const float direction[3])
{
    struct RTCRayHit ray = {.ray = {.org_x = origin[0],
                                    .org_y = origin[1],
                                    .org_z = origin[2],
                                    .dir_x = direction[0],
                                    .dir_y = direction[1],
                                    .dir_z = direction[2],
                                    .tfar = traversal->t_far,
                                    .mask = UINT32_MAX},
                            .hit = {.geomID = RTC_INVALID_GEOMETRY_ID}};
    rtcIntersect1(scene, &traversal->context, &ray);
}

/* In the mesh's own frame, from the sphere about its box or a little behind the start: what is far
 * away does not count in the float error. */
static bool enter_mesh(struct rmap_query *query, int32_t index)
{
    const struct rmap_accel_object *object = &query->accel->object[index];
    rmap_query_local(query, index);
    struct rmap_vec3 p = query->local.origin, d = query->local.direction;
    struct rmap_traversal inner;
    double limit = query->limit;
    traversal_init(&inner, query);
    inner.object = index;
    inner.rate = rmap_length(d);
    d = rmap_scale(d, 1 / inner.rate);
    double enter = rmap_dot(rmap_sub(object->middle, p), d) - object->half;
    enter = rmap_greater(enter, 0) - RMAP_REACH_ERRORS * object->local_error;
    inner.shift = enter / inner.rate;
    (void)shrink(&inner);
    p = rmap_axpy(enter, d, p);
    const float origin[3] = {(float)p.x, (float)p.y, (float)p.z};
    const float direction[3] = {(float)d.x, (float)d.y, (float)d.z};
    search(&inner, object->bottom, origin, direction);
    return query->limit < limit;
}

void rmap_accel_callback(const struct RTCIntersectFunctionNArguments *args)
{
    if (!args->valid[0])
        return;
    const struct rmap_accel_parts *parts = args->geometryUserPtr;
    struct rmap_traversal *traversal = (struct rmap_traversal *)args->context;
    int32_t object = parts->part[args->primID].object;
    if (parts->part[args->primID].part == RMAP_PART_GONE)
        return;
    bool nearer = parts->accel->object[object].shape ? rmap_consider_shape(traversal->query, object)
                                                     : enter_mesh(traversal->query, object);
    if (nearer)
        ((struct RTCRayHit *)args->rayhit)->ray.tfar = shrink(traversal);
}

static inline void query_init(struct rmap_query *query, const struct rmap_accel *accel,
                              const struct rmap_ray *ray, double limit)
{
    query->accel = accel;
    query->ray = ray;
    query->limit = limit;
    query->n_candidate = 0;
    query->local.object = -1;
    for (int i = 0; i < RMAP_MET_SLOTS; i++)
        query->met[i].object = -1;
    for (int i = 0; i < RMAP_DONE_SLOTS; i++)
        query->done[i] = -1;
    rmap_start_find(query);
}

/* Origin of the float ray about the scene's centre: a little behind the start, or where the ray
 * enters the scene's sphere. False: it passes by. */
static bool enter_scene(const struct rmap_query *query, float origin[3], float direction[3],
                        double *shift)
{
    const struct rmap_accel *accel = query->accel;
    struct rmap_vec3 d = query->ray->direction;
    struct rmap_vec3 p = rmap_sub(query->ray->origin, accel->centre);
    double radius = accel->radius + accel->reach;
    double outside = rmap_dot(p, p) - radius * radius;
    *shift = -accel->reach;
    if (outside > 0) {
        double b = rmap_dot(p, d);
        /* the line's nearest point, not b^2 - outside: the start may be very far */
        struct rmap_vec3 nearest = rmap_axpy(-b, d, p);
        double rest = radius * radius - rmap_dot(nearest, nearest);
        if (!(b < 0 && rest >= 0))
            return false;
        *shift += -b - sqrt(rest);
    }
    p = rmap_axpy(*shift, d, p);
    origin[0] = (float)p.x;
    origin[1] = (float)p.y;
    origin[2] = (float)p.z;
    direction[0] = (float)d.x;
    direction[1] = (float)d.y;
    direction[2] = (float)d.z;
    return true;
}

static void look_around(struct rmap_query *query)
{
    if (!query->start.at_edge)
        return;
    rmap_query_local(query, query->start.object);
    (void)rmap_consider_neighbours(query, query->start.object, query->start.primitive);
}

/* Do the bounds of what Embree holds lie beside the ray as far as it is of interest? Mostly where
 * the prefilter has found something near, or little is asked for. */
static bool passes_rest(const struct rmap_query *query, const float origin[3],
                        const float direction[3], double shift)
{
    const struct rmap_accel *accel = query->accel;
    float far = rmap_far_end(query, shift);
    bool beside = false;
    if (!accel->rest_apart)
        return false;
    for (int k = 0; k < 3; k++) {
        float end = origin[k] + far * direction[k]; /* infinite 0: NaN, which is beside nothing */
        beside |= (origin[k] < accel->rest_lower[k]) & (end < accel->rest_lower[k]);
        beside |= (origin[k] > accel->rest_upper[k]) & (end > accel->rest_upper[k]);
    }
    return beside;
}

static void traverse(struct rmap_query *query, RTCScene scene, const float origin[3],
                     const float direction[3], double shift)
{
    struct rmap_traversal traversal;
    traversal_init(&traversal, query);
    traversal.shift = shift;
    traversal.rate = 1;
    if (query->limit < HUGE_VAL)
        (void)shrink(&traversal);
    search(&traversal, scene, origin, direction);
}

/* Bits of the moved meshes whose box the ray meets before `far`. */
RMAP_WIDEST
static uint32_t sift_moved(const struct rmap_accel *accel, const float origin[restrict 3],
                           const float direction[restrict 3], float far)
{
    const float least = 1e-30F; /* of a component: its inverse is to be a number */
    uint32_t bits = 0;
    float rate[3];
    for (int k = 0; k < 3; k++)
        rate[k] = 1 / (fabsf(direction[k]) > least ? direction[k] : least);
    for (int i = 0; i < RMAP_MOVED_MAX; i++) {
        float from = 0, to = far;
        int there = 1;
        for (int k = 0; k < 3; k++) {
            const float a = (accel->moved_lower[k][i] - origin[k]) * rate[k],
                        b = (accel->moved_upper[k][i] - origin[k]) * rate[k], low = a < b ? a : b,
                        high = a < b ? b : a;
            there &= a == a;
            from = low > from ? low : from;
            to = high < to ? high : to;
        }
        bits |= (from <= to) & there ? 1U << i : 0;
    }
    return bits;
}

static void search_moved(struct rmap_query *query, const float origin[3], const float direction[3],
                         double shift)
{
    const struct rmap_accel *accel = query->accel;
    uint32_t bits = sift_moved(accel, origin, direction, rmap_far_end(query, shift));
    for (; bits; bits &= bits - 1)
        (void)enter_mesh(query, accel->moved.part[__builtin_ctz(bits)].object);
}

static void search_rest(struct rmap_query *query, const float origin[3], const float direction[3],
                        double shift)
{
    const struct rmap_accel *accel = query->accel;
    if (accel->rest && !passes_rest(query, origin, direction, shift))
        traverse(query, accel->rest, origin, direction, shift);
    if (accel->moved.n > 0)
        search_moved(query, origin, direction, shift);
}

static void search_shapes(struct rmap_query *query, const float origin[3], const float direction[3],
                          double shift)
{
    if (query->accel->spheres.n > 0)
        rmap_spheres_search(query, origin, direction, shift);
    if (query->accel->prefilter.n_slot > 0)
        rmap_prefilter_search(query, origin, direction, shift);
}

/* Weights are none of them negative: the position lies on the triangle, never beside it. */
static void finish_triangle(const struct rmap_accel_object *object,
                            const struct rmap_candidate *best, struct rmap_hit *hit)
{
    struct rmap_vec3 corner[3], local = best->point;
    rmap_facets_corners(object->facets, best->primitive, corner);
    struct rmap_vec3 e1 = rmap_sub(corner[1], corner[0]), e2 = rmap_sub(corner[2], corner[0]);
    if (!best->on_true)
        local = rmap_axpy(best->point.z, e2, rmap_axpy(best->point.y, e1, corner[0]));
    hit->position = rmap_affine_point(&object->to_world, local);
    hit->normal = rmap_scale(best->normal, 1 / best->length);
}

static inline void finish(struct rmap_query *query, struct rmap_hit *hit)
{
    const struct rmap_candidate *best = rmap_query_best(query);
    const struct rmap_accel_object *object = &query->accel->object[best->object];
    __builtin_prefetch(object->soon);
    rmap_query_local(query, best->object);
    double t = best->on_true ? best->from_start : best->t + query->local.ahead;
    hit->t = best->touches ? 0 : rmap_greater(t, 0);
    hit->object = best->object;
    hit->primitive = best->listed;
    hit->predicted = best->predicted;
    if (object->shape) {
        hit->position = rmap_affine_point(&object->to_world, best->point);
        hit->normal = rmap_affine_transposed(&object->to_local, best->normal);
        if (!object->rigid)
            hit->normal = rmap_normalize(hit->normal);
    } else {
        finish_triangle(object, best, hit);
    }
}

bool rmap_accel_next_within(const struct rmap_accel *accel, const struct rmap_ray *ray,
                            double length, struct rmap_hit *hit)
{
    struct rmap_query query;
    float origin[3], direction[3];
    double shift;
    if (accel->n_object == 0)
        return false;
    if (accel->watch)
        accel->watch(accel->watcher, ray, length);
    query_init(&query, accel, ray, length);
    if (!enter_scene(&query, origin, direction, &shift))
        return false;
    look_around(&query);
    if (accel->rest_inside) {
        search_rest(&query, origin, direction, shift);
        if (!rmap_clearance_holds(&query, origin, direction, shift))
            search_shapes(&query, origin, direction, shift);
    } else {
        search_shapes(&query, origin, direction, shift);
        search_rest(&query, origin, direction, shift);
    }
    if (query.n_candidate == 0)
        return false;
    finish(&query, hit);
    return true;
}

bool rmap_accel_next(const struct rmap_accel *accel, const struct rmap_ray *ray,
                     struct rmap_hit *hit)
{
    return rmap_accel_next_within(accel, ray, HUGE_VAL, hit);
}

bool rmap_accel_meet(const struct rmap_accel *accel, const struct rmap_ray *ray, int32_t object,
                     int32_t primitive, struct rmap_hit *hit)
{
    const struct rmap_mesh *mesh = accel->object[object].mesh;
    struct rmap_query query;
    if (mesh && (size_t)primitive >= mesh->n_triangle)
        return false;
    query_init(&query, accel, ray, HUGE_VAL);
    (void)(mesh ? rmap_consider_triangle(&query, object, primitive)
                : rmap_consider_shape(&query, object));
    if (query.n_candidate == 0)
        return false;
    finish(&query, hit);
    return hit->object == object && hit->primitive == primitive && hit->predicted;
}

void rmap_accel_watch(struct rmap_accel *accel,
                      void (*watch)(void *context, const struct rmap_ray *ray, double length),
                      void *context)
{
    accel->watch = watch;
    accel->watcher = context;
}

enum rmap_status rmap_accel_prepare(struct rmap_accel *accel, struct rmap_replay_ray *ray,
                                    size_t n_ray, struct rmap_error *err)
{
    for (size_t i = 0; i < n_ray; i++) {
        struct rmap_query query;
        query_init(&query, accel, &ray[i].ray, ray[i].length > 0 ? ray[i].length : HUGE_VAL);
        ray[i].misses = !enter_scene(&query, ray[i].origin, ray[i].direction, &ray[i].shift);
    }
    return rmap_accel_build_whole(accel, err);
}

size_t rmap_accel_replay(const struct rmap_accel *accel, const struct rmap_replay_ray *ray,
                         size_t n_ray)
{
    size_t n_hit = 0;
    for (size_t i = 0; i < n_ray; i++) {
        const struct rmap_replay_ray *now = &ray[i];
        struct rmap_query query;
        if (now->misses)
            continue;
        query_init(&query, accel, &now->ray, now->length > 0 ? now->length : HUGE_VAL);
        look_around(&query);
        traverse(&query, accel->whole, now->origin, now->direction, now->shift);
        n_hit += query.n_candidate > 0;
    }
    return n_hit;
}
