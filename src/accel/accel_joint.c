/* SPDX-License-Identifier: MIT
 *
 * Joints: rims of analytic surfaces that coincide, as those of two half spheres or of a tube and
 * its lid. Each surface by itself would decide by its own rounded numbers whether a line passes
 * inside its rim, and light would leak between two that differ. Near a shared rim the line's side
 * of it is decided once, from the ray and one of the rims, for all surfaces that end there.
 *
 * Across the rim, where w is its tangent, surfaces are half lines from a point P in directions a,
 * b, and a line q + t e passes P on the side of the sign of [P - q, e, w]. It crosses the surface a
 * where [P - q, e, w] + u [a, e, w] = 0 with u > 0. If a and b lie on two sides of the line it so
 * crosses exactly one of them, if on one side both or none. A ray that starts on the surface a,
 * however near to P, has the sign of -[a, e, w].
 */
#include <float.h>
#include <stdlib.h>

#include "accel/accel_internal.h"
#include "accel/accel_joint.h"
#include "base/alloc.h"
#include "geometry/shape_internal.h"

/* A rim decides within this share of its size. */
#define NEAR_RIM 1e-4

/* Where it starts within this share, a ray starts at the rim. */
#define AT_RIM 1e-6

/* Lines that meet a surface at its rim at a smaller sine are left to the surface's own numbers. */
#define GRAZING 1e-6

/* Tangents that differ by less go on into one another. */
#define SMOOTH 1e-9

/* In units of coincidence and of rounding: where a shape's own numbers may lie on the wrong side of
 * its rim. */
#define JOINT_ERRORS    4
#define ROUNDING_ERRORS 64

/* A line that passes a rim within this share of that is displaced by TIE: where rims meet in a
 * corner, they tell of the same line then. */
#define TIE_SHARE 0x1p-6
static const struct rmap_vec3 TIE = {0.28172904, 0.53147216, 0.79894311};

static double triple(struct rmap_vec3 a, struct rmap_vec3 b, struct rmap_vec3 c)
{
    return rmap_dot(a, rmap_cross(b, c));
}

/* The point where a line crosses the plane or the cylinder of a circle near t, whichever is the
 * steeper, and [P - q, e, w] there. The steepness is not compared at 45 degrees: scenes have such
 * rays, and all surfaces must choose alike. */
static double circle_side(const struct rmap_rim *rim, struct rmap_vec3 q, struct rmap_vec3 e,
                          double t, struct rmap_rim_point *at)
{
    const double steep = 0.37;
    *at = rmap_rim_point(rim, rmap_axpy(t, e, q));
    double across = at->at.x * e.x + at->at.y * e.y;
    if (fabs(e.z) * rim->size > steep * fabs(across)) {
        struct rmap_vec3 p = rmap_axpy((rim->z - q.z) / e.z, e, q);
        *at = rmap_rim_point(rim, p);
        return (hypot(p.x, p.y) - rim->size) * e.z;
    }
    double a = e.x * e.x + e.y * e.y, middle = -(q.x * e.x + q.y * e.y) / a;
    struct rmap_vec3 nearest = rmap_axpy(middle, e, q);
    double rest = rim->size * rim->size - nearest.x * nearest.x - nearest.y * nearest.y;
    double half = copysign(sqrt(rmap_greater(rest, 0) / a), across);
    struct rmap_vec3 p = rmap_axpy(half, e, nearest);
    *at = rmap_rim_point(rim, p);
    return (rim->z - p.z) * (p.x * e.x + p.y * e.y) / rim->size;
}

/* The same of a curve, at the point of it nearest to the line: so near to the rim its tangent leads
 * there in a few steps. */
static double curve_side(const struct rmap_rim *rim, struct rmap_vec3 q, struct rmap_vec3 e,
                         double t, struct rmap_rim_point *at)
{
    enum { STEPS = 4 };
    const double square = rmap_dot(e, e);
    for (int k = 0; k < STEPS; k++) {
        *at = rmap_rim_point(rim, rmap_axpy(t, e, q));
        const struct rmap_vec3 to = rmap_sub(at->at, q);
        const double along = rmap_dot(e, at->along), across = square - along * along;
        if (!(across > GRAZING * GRAZING * square))
            break;
        t = (rmap_dot(to, e) - along * rmap_dot(to, at->along)) / across;
    }
    return triple(rmap_sub(at->at, q), e, at->along);
}

/* The same for any kind of rim, in its own frame. */
static double line_side(const struct rmap_rim *rim, struct rmap_vec3 q, struct rmap_vec3 e,
                        double t, struct rmap_rim_point *at)
{
    if (rim->curve)
        return curve_side(rim, q, e, t, at);
    if (!rim->straight)
        return circle_side(rim, q, e, t, at);
    *at = rmap_rim_point(rim, rmap_axpy(t, e, q));
    return triple(rmap_sub(rim->at, q), e, rim->along);
}

/* Of a line's numbers that starts at q, in a shape's frame. */
static double rounding(struct rmap_vec3 q)
{
    return DBL_EPSILON * ROUNDING_ERRORS * rmap_length(q);
}

/* The point of the object's rim nearest to p (world), in the world; tangents are no more unit or
 * orthogonal where it is scaled. */
static struct rmap_rim_point world_point(const struct rmap_accel_object *object, int rim,
                                         struct rmap_vec3 p)
{
    struct rmap_rim_point at =
        rmap_rim_point(&object->rims->rim[rim], rmap_affine_point(&object->to_local, p));
    at.at = rmap_affine_point(&object->to_world, at.at);
    at.along = rmap_affine_vector(&object->to_world, at.along);
    at.inward = rmap_affine_vector(&object->to_world, at.inward);
    return at;
}

/* The shape that the ray starts from, if it has joints. */
static const struct rmap_accel_object *start_shape(const struct rmap_query *query)
{
    int32_t object = query->start.object;
    return object >= 0 && query->accel->object[object].rims ? &query->accel->object[object] : NULL;
}

/* Does the ray start at this rim of that shape? At the point p (world) of it, where that is given.
 */
static bool starts_at(const struct rmap_query *query, int rim, const struct rmap_vec3 *p)
{
    const struct rmap_accel_object *from = start_shape(query);
    struct rmap_vec3 start = rmap_affine_point(&from->to_local, query->ray->origin);
    if (!rmap_rim_is_near(&from->rims->rim[rim], start, AT_RIM))
        return false;
    double most = 2 * AT_RIM * from->rims->rim[rim].size;
    return !p || rmap_length(rmap_sub(rmap_affine_point(&from->to_local, *p), start)) <= most;
}

/* Where a ray starts from a rim at p, its line is taken to pass that a little way into the surface
 * that it starts on. */
static bool displacement(const struct rmap_query *query, const struct rmap_vec3 *p,
                         struct rmap_vec3 *way)
{
    const struct rmap_accel_object *from = start_shape(query);
    bool at = false;
    *way = rmap_vec3(0, 0, 0);
    for (int k = 0; from && k < from->rims->n; k++)
        if (starts_at(query, k, p)) {
            *way = rmap_add(*way, world_point(from, k, query->ray->origin).inward);
            at = true;
        }
    return at;
}

/* Does the line cross the surface at this rim, as the joint sees it? */
static bool crosses(const struct rmap_query *query, int32_t object, int rim, double t)
{
    const struct rmap_accel *accel = query->accel;
    const struct rmap_joint *joint = &accel->joint[accel->object[object].rims->joint[rim]];
    const struct rmap_accel_object *frame = &accel->object[joint->object];
    struct rmap_vec3 q = rmap_affine_point(&frame->to_local, query->ray->origin);
    struct rmap_vec3 e = rmap_affine_vector(&frame->to_local, query->ray->direction);
    struct rmap_rim_point at;
    struct rmap_vec3 way;
    double side = line_side(&frame->rims->rim[joint->rim], q, e, t, &at);
    double tie = TIE_SHARE * (frame->rims->error[joint->rim] + rounding(q));
    struct rmap_vec3 p = rmap_affine_point(&frame->to_world, at.at);
    bool starts = query->start.object != object && displacement(query, &p, &way);
    if (starts || fabs(side) <= tie * rmap_length(e))
        side = -triple(rmap_affine_vector(&frame->to_local, starts ? way : TIE), e, at.along);
    /* a ray that starts at the rim may meet a curved surface again a little farther on */
    at = rmap_rim_point(&frame->rims->rim[joint->rim], rmap_axpy(t, e, q));
    p = rmap_affine_point(&frame->to_world, at.at);
    struct rmap_vec3 a =
        rmap_affine_vector(&frame->to_local, world_point(&accel->object[object], rim, p).inward);
    double slope = triple(a, e, at.along);
    return side >= 0 ? slope < 0 : slope > 0;
}

bool rmap_joints_decide(struct rmap_joints *joints, double t, struct rmap_vec3 *point, bool plain)
{
    const struct rmap_query *query = joints->query;
    const struct rmap_object_rims *rims = query->accel->object[joints->object].rims;
    struct rmap_vec3 e = query->local.direction;
    bool near = false, belongs = true;
    for (int k = 0; k < rims->n && belongs; k++) {
        if (!rmap_rim_is_near(&rims->rim[k], *point, NEAR_RIM))
            continue;
        struct rmap_rim_point at = rmap_rim_point(&rims->rim[k], *point);
        double inside = rmap_dot(rmap_sub(*point, at.at), at.inward);
        double sine = fabs(triple(at.inward, e, at.along)) / rmap_length(e);
        bool clear = rims->joint[k] < 0 || sine < GRAZING ||
                     fabs(inside) * sine > rims->error[k] + rounding(query->local.origin);
        near = true;
        belongs = clear ? inside >= 0 : crosses(query, joints->object, k, t);
        if (belongs && inside < 0) {
            *point = at.at;
            joints->overruled = true;
        }
    }
    if (!near)
        return plain;
    joints->overruled |= belongs != plain;
    return belongs;
}

bool rmap_joint_at_start(const struct rmap_query *query, int32_t object, bool *meets_ret)
{
    const struct rmap_accel_object *from = start_shape(query),
                                   *other = &query->accel->object[object];
    if (!from || !other->rims || from == other)
        return false;
    for (int i = 0; i < from->rims->n; i++)
        for (int k = 0; k < other->rims->n; k++) {
            if (from->rims->joint[i] < 0 || from->rims->joint[i] != other->rims->joint[k] ||
                !starts_at(query, i, NULL))
                continue;
            struct rmap_rim_point at = world_point(from, i, query->ray->origin);
            struct rmap_vec3 b = world_point(other, k, query->ray->origin).inward;
            double angle = triple(at.inward, b, at.along);
            bool smooth =
                rmap_dot(at.inward, b) < 0 &&
                fabs(angle) <= SMOOTH * fabs(rmap_dot(at.inward, b)) * rmap_length(at.along);
            *meets_ret = !smooth && angle * triple(b, query->ray->direction, at.along) > 0;
            return true;
        }
    return false;
}

/* Building: rims whose middles agree are neighbours in a list that is sorted along some direction.
 */
struct entry {
    double key;
    int32_t object, rim, joint;
};

static const struct rmap_vec3 SORTED_ALONG = {0.36235775447667357, 0.61803398874989485,
                                              0.69814917480233045};

static struct rmap_vec3 world_middle(const struct rmap_accel_object *object,
                                     const struct rmap_rim *rim)
{
    struct rmap_vec3 at = rmap_affine_point(&object->to_world, rmap_rim_middle(rim));
    if (!rim->straight)
        return at;
    struct rmap_vec3 w = rmap_normalize(rmap_affine_vector(&object->to_world, rim->along));
    return rmap_axpy(-rmap_dot(at, w), w, at); /* edges of one line may be of two lengths */
}

/* Do points of the first rim lie on the second? An affine circle is one where five of its points
 * are; of curves as many are taken to be enough. */
static bool coincides(const struct rmap_accel_object *a, const struct rmap_rim *first,
                      const struct rmap_accel_object *b, const struct rmap_rim *second)
{
    enum { POINTS = 6 };
    if (first->straight != second->straight)
        return false;
    double error = (a->tolerance + b->tolerance) * rmap_affine_norm(&b->to_local);
    for (int i = 0; i < (first->straight ? 2 : POINTS); i++) {
        struct rmap_vec3 p = rmap_rim_sample(first, i, POINTS);
        p = rmap_affine_point(&b->to_local, rmap_affine_point(&a->to_world, p));
        if (!(rmap_length(rmap_sub(p, rmap_rim_point(second, p).at)) <= error))
            return false;
    }
    return true;
}

static int by_key(const void *a, const void *b)
{
    const struct entry *first = a, *second = b;
    if (first->key != second->key)
        return first->key < second->key ? -1 : 1;
    return first->object != second->object ? (first->object < second->object ? -1 : 1)
                                           : first->rim - second->rim;
}

static struct rmap_rim rim_at(const struct rmap_accel *accel, const struct entry *entry)
{
    struct rmap_rim rim[RMAP_RIM_MAX];
    (void)rmap_shape_rims(accel->object[entry->object].shape, rim);
    return rim[entry->rim];
}

/* The entry's joint: that of the first of its neighbours before it with which it coincides. */
static void join(struct rmap_accel *accel, struct entry *entry, size_t i, double widest)
{
    const struct rmap_accel_object *object = &accel->object[entry[i].object];
    struct rmap_rim rim = rim_at(accel, &entry[i]);
    for (size_t k = i; k-- > 0 && entry[i].key - entry[k].key <= widest;) {
        struct rmap_rim other = rim_at(accel, &entry[k]);
        if (entry[k].object == entry[i].object ||
            !coincides(object, &rim, &accel->object[entry[k].object], &other))
            continue;
        if (entry[k].joint < 0) {
            entry[k].joint = (int32_t)accel->n_joint;
            accel->joint[accel->n_joint++] = (struct rmap_joint){entry[k].object, entry[k].rim};
        }
        entry[i].joint = entry[k].joint;
        return;
    }
}

static int rims_of(const struct rmap_accel_object *object, struct rmap_rim rim[RMAP_RIM_MAX])
{
    return object->shape ? rmap_shape_rims(object->shape, rim) : 0;
}

static size_t count_rims(const struct rmap_accel *accel)
{
    size_t n = 0;
    struct rmap_rim rim[RMAP_RIM_MAX];
    for (size_t i = 0; i < accel->n_object; i++)
        n += (size_t)rims_of(&accel->object[i], rim);
    return n;
}

/* Returns how far apart the keys of two rims that coincide may lie. */
static double list_rims(const struct rmap_accel *accel, struct entry *entry)
{
    double widest = 0;
    for (size_t i = 0; i < accel->n_object; i++) {
        const struct rmap_accel_object *object = &accel->object[i];
        struct rmap_rim rim[RMAP_RIM_MAX];
        int n = rims_of(object, rim);
        for (int k = 0; k < n; k++)
            *entry++ = (struct entry){rmap_dot(world_middle(object, &rim[k]), SORTED_ALONG),
                                      (int32_t)i, k, -1};
        if (n > 0)
            widest = rmap_greater(widest, 2 * object->tolerance);
    }
    return widest;
}

static enum rmap_status set_rims(struct rmap_accel *accel, const struct entry *entry, size_t n,
                                 struct rmap_error *err)
{
    size_t n_joined = 0;
    for (size_t i = 0; i < n; i++)
        n_joined += entry[i].joint >= 0;
    if (n_joined == 0)
        return RMAP_OK;
    accel->rims = rmap_alloc(n_joined, sizeof(*accel->rims));
    if (!accel->rims)
        return rmap_error_set(err, RMAP_SYSTEM, "no memory for %zu joints", n_joined);
    for (size_t i = 0, used = 0; i < n; i++) {
        struct rmap_accel_object *object = &accel->object[entry[i].object];
        if (entry[i].joint < 0)
            continue;
        if (!object->rims) {
            struct rmap_object_rims *rims = &accel->rims[used++];
            rims->n = rmap_shape_rims(object->shape, rims->rim);
            for (int k = 0; k < RMAP_RIM_MAX; k++)
                rims->joint[k] = -1;
            object->rims = rims;
        }
        struct rmap_object_rims *rims = &accel->rims[object->rims - accel->rims];
        rims->joint[entry[i].rim] = entry[i].joint;
        const struct rmap_accel_object *frame = &accel->object[accel->joint[entry[i].joint].object];
        rims->error[entry[i].rim] = JOINT_ERRORS * (object->tolerance + frame->tolerance) *
                                    rmap_affine_norm(&object->to_local);
    }
    return RMAP_OK;
}

enum rmap_status rmap_joints_build(struct rmap_accel *accel, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n = count_rims(accel);
    if (n == 0)
        return RMAP_OK;
    struct entry *entry = rmap_alloc(n, sizeof(*entry));
    accel->joint = rmap_alloc(n, sizeof(*accel->joint));
    if (!entry || !accel->joint) {
        st = rmap_error_set(err, RMAP_SYSTEM, "no memory for %zu rims", n);
        goto out;
    }
    double widest = list_rims(accel, entry);
    qsort(entry, n, sizeof(*entry), by_key);
    for (size_t i = 1; i < n; i++)
        join(accel, entry, i, widest);
    RMAP_TRY(set_rims(accel, entry, n, err));
out:
    rmap_free(entry);
    return st;
}

void rmap_joints_release(struct rmap_accel *accel)
{
    for (size_t i = 0; accel->rims && i < accel->n_object; i++)
        accel->object[i].rims = NULL;
    rmap_free(accel->rims);
    rmap_free(accel->joint);
    accel->rims = NULL;
    accel->joint = NULL;
    accel->n_joint = 0;
}
