/* SPDX-License-Identifier: MIT
 *
 * Where an analytic surface ends: circles about its axis, or the edges of a rectangle.
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
    }
    return n;
}

bool rmap_rim_is_near(const struct rmap_rim *rim, struct rmap_vec3 p, double zone)
{
    double near = zone * rim->size;
    if (!rim->straight)
        return fabs(p.z - rim->z) <= near &&
               fabs(p.x * p.x + p.y * p.y - rim->size * rim->size) <= 2 * near * rim->size;
    struct rmap_vec3 to = rmap_sub(p, rim->at);
    double along = rmap_dot(to, rim->along);
    return fabs(along) <= rim->size + near && fabs(rmap_dot(to, rim->inward)) <= near &&
           fabs(p.z) <= near;
}

struct rmap_rim_point rmap_rim_point(const struct rmap_rim *rim, struct rmap_vec3 p)
{
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
