/* SPDX-License-Identifier: MIT
 *
 * Where the ray starts. Four questions are decided here, all by topology rather than by a
 * distance to be skipped:
 *
 * - A start at an edge of its triangle, to double rounding: does the neighbour lie ahead? Topology
 *   is then decided for a point a hair inside the triangle, and on the side that the ray takes.
 * - A surface that coincides with the start and is parallel to it: touching faces. The contact
 *   list says whether it is still to be met.
 * - A shape that shares the rim at which the ray starts: see accel_joint.c.
 * - One that crosses the start: it counts when the start's triangle lies on the side from which
 *   the ray would meet it.
 */
#include <math.h>

#include "accel/accel_cell.h"
#include "accel/accel_internal.h"
#include "accel/accel_joint.h"
#include "accel/accel_start.h"
#include "accel/accel_triangle.h"
#include "geometry/shape_internal.h"

/* In units of double rounding: a start is ambiguous when the ray, displaced by one, may pass an
 * edge of its triangle on the other side; the point inside lies this far from the edges and below
 * the plane. Four times farther than deep, it lies inside wedges down to 15 degrees. */
#define AMBIGUOUS_ERRORS 4
#define ASIDE_ERRORS     8
#define DEPTH_ERRORS     2

/* How far to the middle of the triangle, as a share, a point must move to be `aside` from each
 * edge. Shares b of the heights; edges squared; square of twice the area. */
static double share_to_middle(const double b[3], const double edge[3], double square, double aside)
{
    double share = 0;
    for (int k = 0; k < 3; k++) {
        double least = aside * sqrt(edge[k] / square);
        if (least >= 1.0 / 3)
            return 1;
        if (b[k] < least)
            share = rmap_greater(share, (least - b[k]) / (1.0 / 3 - b[k]));
    }
    return rmap_lesser(share, 1);
}

static void set_inside(struct rmap_query *query, const struct rmap_accel_object *object)
{
    struct rmap_start *start = &query->start;
    struct rmap_vec3 corner[3];
    rmap_query_local(query, start->object);
    rmap_facets_corners(object->facets, start->primitive, corner);
    struct rmap_vec3 origin = query->local.origin, d = query->local.direction;
    struct rmap_vec3 e1 = rmap_sub(corner[1], corner[0]), e2 = rmap_sub(corner[2], corner[0]);
    struct rmap_vec3 w = rmap_sub(origin, corner[0]), n = rmap_cross(e1, e2);
    struct rmap_vec3 e0 = rmap_sub(e2, e1);
    double square = rmap_dot(n, n), facing = rmap_dot(n, d);
    double u = rmap_dot(rmap_cross(w, e2), n), v = rmap_dot(rmap_cross(e1, w), n);
    double b[3] = {square - u - v, u, v};
    double edge[3] = {rmap_dot(e0, e0), rmap_dot(e2, e2), rmap_dot(e1, e1)};
    /* (b / |n|)^2 > (AMBIGUOUS error / cosine)^2 edge, without roots or divisions */
    double least = rmap_lesser(b[0], rmap_lesser(u, v)),
           longest = rmap_greater(edge[0], rmap_greater(edge[1], edge[2]));
    double clear = least > 0 ? least * least * facing * facing : 0;
    double unit = AMBIGUOUS_ERRORS * AMBIGUOUS_ERRORS * square * square * longest * rmap_dot(d, d);
    start->at_edge = !(clear > unit * object->local_error * object->local_error);
    if (clear > unit * object->local_exact * object->local_exact)
        return;
    for (int k = 0; k < 3; k++)
        b[k] /= square;
    struct rmap_vec3 middle =
        rmap_scale(rmap_add(corner[0], rmap_add(corner[1], corner[2])), 1.0 / 3);
    double share = share_to_middle(b, edge, square, ASIDE_ERRORS * object->local_exact);
    double depth = copysign(DEPTH_ERRORS * object->local_exact / sqrt(square), facing);
    start->nudged = true;
    start->inside = rmap_axpy(depth, n, rmap_axpy(share, rmap_sub(middle, origin), origin));
    query->local.object = -1; /* the line starts there from now on */
}

void rmap_start_find(struct rmap_query *query)
{
    const struct rmap_contact *contact = &query->ray->contact;
    struct rmap_start *start = &query->start;
    int32_t k = contact->backward ? contact->passed : contact->passed - 1;
    start->object = -1;
    start->primitive = start->surface = -1;
    start->tolerance = 0;
    start->nudged = start->at_edge = false;
    start->has_normal = false;
    if (k < 0 || k >= contact->n)
        return;
    const struct rmap_accel_object *object = &query->accel->object[contact->surface[k].object];
    start->object = contact->surface[k].object;
    start->primitive = contact->surface[k].primitive;
    start->tolerance = object->tolerance;
    if (object->cells)
        start->surface = object->cells->its[start->primitive];
    if (object->mesh && !(object->cells && rmap_cell_is_true(object->cells, start->primitive)))
        set_inside(query, object);
}

static void set_normal(struct rmap_query *query)
{
    struct rmap_start *start = &query->start;
    const struct rmap_accel_object *object = &query->accel->object[start->object];
    struct rmap_vec3 normal;
    if (object->mesh) {
        struct rmap_vec3 corner[3];
        rmap_facets_corners(object->facets, start->primitive, corner);
        normal = rmap_cross(rmap_sub(corner[1], corner[0]), rmap_sub(corner[2], corner[0]));
        if (object->cells)
            normal =
                rmap_true_normal(rmap_cell_surface(object->cells, start->primitive),
                                 rmap_affine_point(&object->to_local, query->ray->origin), normal);
        start->middle = rmap_affine_point(
            &object->to_world,
            rmap_scale(rmap_add(corner[0], rmap_add(corner[1], corner[2])), 1.0 / 3));
    } else {
        normal = rmap_shape_normal(object->shape,
                                   rmap_affine_point(&object->to_local, query->ray->origin));
    }
    start->normal = rmap_normalize(rmap_affine_transposed(&object->to_local, normal));
    start->has_normal = true;
}

/* A ray that starts in space on a surface: between two media its own medium says on which side;
 * where it cannot, the light is taken to come from the surface, as a lamp's does. */
static bool meets_from_space(const struct rmap_query *query, const struct rmap_touch *touch)
{
    const struct rmap_accel_object *object = &query->accel->object[touch->object];
    int32_t front = object->medium_front, back = object->medium_back;
    if (front < 0 || back < 0 || front == back)
        return false;
    int32_t near_medium = touch->facing < 0 ? front : back;
    int32_t far_medium = touch->facing < 0 ? back : front;
    if (query->ray->medium == near_medium || query->ray->medium == far_medium)
        return query->ray->medium == near_medium;
    return touch->t >= 0;
}

/* Is the surface listed? A triangle stands for its whole face: its neighbours in the same plane
 * are met together with it. One turned the other way, as of a second body in the same file, is
 * another face. */
static bool is_listed(const struct rmap_query *query, int32_t k, const struct rmap_touch *touch)
{
    const struct rmap_contact *contact = &query->ray->contact;
    const struct rmap_accel_object *object = &query->accel->object[touch->object];
    if (contact->surface[k].object != touch->object)
        return false;
    if (contact->surface[k].primitive == touch->primitive)
        return true;
    if (object->cells)
        return object->cells->its[contact->surface[k].primitive] ==
               object->cells->its[touch->primitive];
    struct rmap_vec3 corner[3];
    rmap_facets_corners(object->facets, contact->surface[k].primitive, corner);
    struct rmap_vec3 n = rmap_cross(rmap_sub(corner[1], corner[0]), rmap_sub(corner[2], corner[0]));
    n = rmap_normalize(rmap_affine_transposed(&object->to_local, n));
    return rmap_dot(n, touch->normal) > 0 &&
           rmap_length(rmap_cross(n, touch->normal)) <= RMAP_PARALLEL_OWN;
}

bool rmap_start_meets(struct rmap_query *query, struct rmap_touch *touch)
{
    const struct rmap_contact *contact = &query->ray->contact;
    struct rmap_start *start = &query->start;
    bool meets;
    if (start->object < 0)
        return meets_from_space(query, touch);
    if (rmap_joint_at_start(query, touch->object, &meets))
        return meets;
    for (int32_t k = 0; k < contact->n; k++)
        if (is_listed(query, k, touch)) {
            touch->primitive = contact->surface[k].primitive;
            return k == (contact->backward ? contact->passed - 1 : contact->passed);
        }
    if (!start->has_normal)
        set_normal(query);
    bool own = start->object == touch->object;
    struct rmap_vec3 sine = rmap_cross(start->normal, touch->normal);
    if (rmap_length(sine) <= (own ? RMAP_PARALLEL_OWN : RMAP_PARALLEL_OTHER))
        return !contact->backward && contact->passed == contact->n;
    if (own)
        return touch->t > 0;
    if (touch->rank == RMAP_RANK_OTHER) /* a neighbour met out of order by rounding */
        return false;
    if (!query->accel->object[start->object].mesh || !query->accel->object[touch->object].mesh)
        return touch->t >= 0;
    double side = rmap_dot(rmap_sub(start->middle, touch->point), touch->normal);
    return side * touch->facing < 0;
}
