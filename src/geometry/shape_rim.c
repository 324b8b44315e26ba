/* SPDX-License-Identifier: MIT
 *
 * Where an analytic surface ends: circles about its axis, the edges of a rectangle, or curves that
 * follow a sag along an outline.
 */
#include "geometry/shape_rim.h"

#include "geometry/shape_internal.h"

/* Circle of this radius whose surface goes on in the direction (radial, axial). */
static struct rmap_rim circle(double radius, double z, double radial, double axial)
{
    double length = hypot(radial, axial);
    return (struct rmap_rim){
        .size = radius, .z = z, .radial = radial / length, .axial = axial / length};
}

/* Rounding of what the sag formula has under its root, which is 0 at the end of a conic: that of a
 * half sphere. */
#define END_ROUNDING 1e-14

/* At radius r of a CONIC; outward 1: the surface lies beyond it. */
static struct rmap_rim conic_rim(const struct rmap_shape *shape, double r, double outward)
{
    double c = shape->curvature, s = r * r;
    if (fabs(1 - (1 + shape->conic) * c * c * s) < END_ROUNDING)
        return circle(r, c * s, 0, outward * copysign(1, c));
    return circle(r, rmap_conic_sag(shape, s), outward,
                  outward * 2 * r * rmap_conic_slope(shape, s));
}

static struct rmap_rim edge(struct rmap_vec3 at, struct rmap_vec3 along)
{
    return (struct rmap_rim){.straight = true,
                             .size = rmap_length(along),
                             .at = at,
                             .along = rmap_normalize(along),
                             .inward = rmap_scale(rmap_normalize(at), -1)};
}

/* ---- curves ---- */

static double curve_height(const struct rmap_rim *rim, double x, double y, struct rmap_height *at)
{
    const struct rmap_shape *shape = rim->curve;
    *at = rmap_sag_height(shape->sag[rim->end], x, y);
    return at->z + (rim->end ? shape->length : 0);
}

/* Above or below the point of the outline that belongs to p. */
static struct rmap_vec3 on_outline(const struct rmap_rim *rim, struct rmap_vec3 p)
{
    const struct rmap_aperture *a = &rim->curve->outline;
    double x = p.x - a->at[0], y = p.y - a->at[1];
    if (rim->side >= 0) {
        const int k = rim->side % 2;
        *(k ? &y : &x) = rim->side < 2 ? a->half[k] : -a->half[k];
    } else {
        const double hx = rim->side == -2 ? a->inner : a->half[0],
                     hy = rim->side == -2 ? a->inner : a->half[1];
        const double r = hypot(x / hx, y / hy);
        x = r > 0 ? x / r : hx;
        y = r > 0 ? y / r : 0;
    }
    return rmap_vec3(a->at[0] + x, a->at[1] + y, 0);
}

static struct rmap_vec3 outward(const struct rmap_rim *rim, struct rmap_vec3 p)
{
    const struct rmap_aperture *a = &rim->curve->outline;
    if (rim->side >= 0)
        return rmap_vec3(rim->side == 0   ? 1
                         : rim->side == 2 ? -1
                                          : 0,
                         rim->side == 1   ? 1
                         : rim->side == 3 ? -1
                                          : 0,
                         0);
    if (rim->side == -2)
        return rmap_normalize(rmap_vec3(a->at[0] - p.x, a->at[1] - p.y, 0));
    return rmap_aperture_outward(a, p.x, p.y);
}

static struct rmap_rim_point curve_point(const struct rmap_rim *rim, struct rmap_vec3 p)
{
    struct rmap_height at;
    struct rmap_vec3 q = on_outline(rim, p);
    const struct rmap_vec3 out = outward(rim, q);
    q.z = curve_height(rim, q.x, q.y, &at);
    const struct rmap_vec3 along =
        rmap_normalize(rmap_vec3(-out.y, out.x, at.y * out.x - at.x * out.y));
    const bool wall = rim->curve->type == RMAP_SHAPE_WALL;
    const struct rmap_vec3 normal = wall ? out : rmap_vec3(-at.x, -at.y, 1);
    struct rmap_vec3 inward = rmap_normalize(rmap_cross(normal, along));
    /* of a cap it leads towards the middle, as the cross product does; of a wall away from its end
     */
    if (wall && (inward.z < 0) != (rim->end == 1))
        inward = rmap_scale(inward, -1);
    return (struct rmap_rim_point){q, along, inward};
}

__attribute__((noinline)) /* rmap_rim_is_near stays short for circles */
static bool
is_near_curve(const struct rmap_rim *rim, struct rmap_vec3 p, double near)
{
    /* a wall's points lie on its outline: those of its other sides are not near */
    const bool wall = rim->curve->type == RMAP_SHAPE_WALL;
    const double beside = wall ? 1e-7 * rim->size : near;
    const struct rmap_vec3 q = on_outline(rim, p);
    if (fabs(p.x - q.x) > beside || fabs(p.y - q.y) > beside)
        return false;
    if (rim->side >= 0) {
        const struct rmap_aperture *a = &rim->curve->outline;
        const int k = 1 - rim->side % 2;
        if (fabs((k ? p.y : p.x) - a->at[k]) > a->half[k] + beside)
            return false;
    }
    struct rmap_height at;
    return !wall || fabs(p.z - curve_height(rim, q.x, q.y, &at)) <= near;
}

/* A circle where it is one. */
static struct rmap_rim curve_rim(const struct rmap_shape *shape, int end, int side)
{
    const struct rmap_aperture *a = &shape->outline;
    const struct rmap_sag *sag = shape->sag[end];
    const double r = side == -2 ? a->inner : a->half[0];
    if (side < 0 && rmap_aperture_is_circle(a) && (sag->fresnel || rmap_sag_is_revolved(sag))) {
        const struct rmap_height at = rmap_sag_height(sag, r, 0);
        const double inward = side == -2 ? 1 : -1;
        if (shape->type == RMAP_SHAPE_SAG)
            return circle(r, at.z, inward, inward * at.x);
        return circle(r, at.z + (end ? shape->length : 0), 0, end ? -1 : 1);
    }
    double size = rmap_max(a->half[0], a->half[1]);
    if (side >= 0)
        size = a->half[1 - side % 2];
    return (struct rmap_rim){
        .size = side == -2 ? a->inner : size, .curve = shape, .end = end, .side = side};
}

static int sag_rims(const struct rmap_shape *shape, struct rmap_rim rim[RMAP_RIM_MAX])
{
    int n = 0;
    if (!shape->outline.rectangle)
        rim[n++] = curve_rim(shape, 0, -1);
    for (int side = 0; shape->outline.rectangle && side < 4; side++)
        rim[n++] = curve_rim(shape, 0, side);
    if (shape->outline.inner > 0)
        rim[n++] = curve_rim(shape, 0, -2);
    return n;
}

/* The corner between a side of a rectangle and the next one. */
static struct rmap_rim corner_rim(const struct rmap_shape *shape, double sign)
{
    const struct rmap_aperture *a = &shape->outline;
    const struct rmap_vec3 n = rmap_side_outward(shape->side),
                           on = rmap_scale(rmap_side_outward((shape->side + 1) % 4), sign);
    const double x = a->at[0] + (n.x + on.x) * a->half[0], y = a->at[1] + (n.y + on.y) * a->half[1];
    const double low = rmap_sag_height(shape->sag[0], x, y).z,
                 high = shape->length + rmap_sag_height(shape->sag[1], x, y).z;
    return (struct rmap_rim){.straight = true,
                             .size = 0.5 * (high - low),
                             .at = rmap_vec3(x, y, 0.5 * (low + high)),
                             .along = rmap_vec3(0, 0, 1),
                             .inward = rmap_scale(on, -1)};
}

static int wall_rims(const struct rmap_shape *shape, struct rmap_rim rim[RMAP_RIM_MAX])
{
    int n = 0;
    for (int end = 0; end < 2; end++)
        rim[n++] = curve_rim(shape, end, shape->outline.rectangle ? shape->side : -1);
    for (int sign = -1; shape->outline.rectangle && sign <= 1; sign += 2)
        rim[n++] = corner_rim(shape, sign);
    return n;
}

int rmap_shape_rims(const struct rmap_shape *shape, struct rmap_rim rim[RMAP_RIM_MAX])
{
    struct rmap_vec3 half = rmap_vec3(0.5 * shape->size[0], 0.5 * shape->size[1], 0);
    double cone = shape->radius2 - shape->radius;
    int n = 0;
    switch (shape->type) {
    case RMAP_SHAPE_CONIC:
        rim[n++] = conic_rim(shape, shape->aperture, -1);
        if (shape->inner > 0)
            rim[n++] = conic_rim(shape, shape->inner, 1);
        break;
    case RMAP_SHAPE_DISC:
        rim[n++] = circle(shape->aperture, 0, -1, 0);
        if (shape->inner > 0)
            rim[n++] = circle(shape->inner, 0, 1, 0);
        break;
    case RMAP_SHAPE_TUBE:
        if (shape->radius > 0)
            rim[n++] = circle(shape->radius, 0, cone, shape->length);
        if (shape->radius2 > 0)
            rim[n++] = circle(shape->radius2, shape->length, -cone, -shape->length);
        break;
    case RMAP_SHAPE_RECTANGLE:
        for (int sign = -1; sign <= 1; sign += 2) {
            rim[n++] = edge(rmap_vec3(sign * half.x, 0, 0), rmap_vec3(0, half.y, 0));
            rim[n++] = edge(rmap_vec3(0, sign * half.y, 0), rmap_vec3(half.x, 0, 0));
        }
        break;
    case RMAP_SHAPE_SPHERE:
        break;
    case RMAP_SHAPE_SAG:
        return sag_rims(shape, rim);
    case RMAP_SHAPE_WALL:
        return wall_rims(shape, rim);
    }
    return n;
}

bool rmap_rim_is_near(const struct rmap_rim *rim, struct rmap_vec3 p, double zone)
{
    double near = zone * rim->size;
    if (rim->curve)
        return is_near_curve(rim, p, near);
    if (!rim->straight)
        return fabs(p.z - rim->z) <= near &&
               fabs(p.x * p.x + p.y * p.y - rim->size * rim->size) <= 2 * near * rim->size;
    struct rmap_vec3 to = rmap_sub(p, rim->at);
    double along = rmap_dot(to, rim->along);
    return fabs(along) <= rim->size + near && fabs(rmap_dot(to, rim->inward)) <= near &&
           fabs(rmap_dot(to, rmap_cross(rim->along, rim->inward))) <= near;
}

struct rmap_vec3 rmap_rim_sample(const struct rmap_rim *rim, int i, int n)
{
    const double angle = 2 * RMAP_PI / n * (i + 0.5), along = (2.0 * i + 1) / n - 1;
    if (rim->straight)
        return rmap_axpy((i == 0 ? -1 : 1) * rim->size, rim->along, rim->at);
    if (!rim->curve)
        return rmap_vec3(rim->size * cos(angle), rim->size * sin(angle), rim->z);
    const struct rmap_aperture *a = &rim->curve->outline;
    struct rmap_vec3 p =
        rmap_vec3(a->at[0] + a->half[0] * cos(angle), a->at[1] + a->half[1] * sin(angle), 0);
    if (rim->side >= 0)
        p = rmap_vec3(a->at[0] + a->half[0] * along, a->at[1] + a->half[1] * along, 0);
    return curve_point(rim, p).at;
}

struct rmap_vec3 rmap_rim_middle(const struct rmap_rim *rim)
{
    enum { POINTS = 4 };
    struct rmap_vec3 sum = {0, 0, 0};
    if (!rim->curve)
        return rim->straight ? rim->at : rmap_vec3(0, 0, rim->z);
    for (int i = 0; i < POINTS; i++)
        sum = rmap_add(sum, rmap_rim_sample(rim, i, POINTS));
    return rmap_scale(sum, 1.0 / POINTS);
}

struct rmap_rim_point rmap_rim_point(const struct rmap_rim *rim, struct rmap_vec3 p)
{
    if (rim->curve)
        return curve_point(rim, p);
    if (rim->straight) {
        double along = rmap_dot(rmap_sub(p, rim->at), rim->along);
        return (struct rmap_rim_point){rmap_axpy(along, rim->along, rim->at), rim->along,
                                       rim->inward};
    }
    double r = hypot(p.x, p.y);
    double x = r > 0 ? p.x / r : 1, y = r > 0 ? p.y / r : 0;
    return (struct rmap_rim_point){rmap_vec3(rim->size * x, rim->size * y, rim->z),
                                   rmap_vec3(-y, x, 0),
                                   rmap_vec3(rim->radial * x, rim->radial * y, rim->axial)};
}
