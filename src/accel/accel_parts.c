/* SPDX-License-Identifier: MIT
 *
 * Boxes for shapes. A tube or a ring in one box would be looked at by every ray that runs through
 * its middle, as light in a lens barrel does; in sectors it is not.
 */
#include "accel/accel_internal.h"

enum { SECTORS = 16 }; /* a multiple of 4: x and y are monotonic within each */

void rmap_shell_radii(const struct rmap_shape *shape, double radius[2])
{
    radius[0] = 0;
    radius[1] = shape->radius;
    switch (shape->type) {
    case RMAP_SHAPE_CONIC:
    case RMAP_SHAPE_DISC:
        radius[0] = shape->inner;
        radius[1] = shape->aperture;
        break;
    case RMAP_SHAPE_TUBE:
        radius[0] = rmap_lesser(shape->radius, shape->radius2);
        radius[1] = rmap_greater(shape->radius, shape->radius2);
        break;
    case RMAP_SHAPE_RECTANGLE:
        radius[1] = 0.5 * hypot(shape->size[0], shape->size[1]);
        break;
    case RMAP_SHAPE_SPHERE:
        break;
    }
}

/* Is the middle hollow enough for sectors? */
static bool hollow(const struct rmap_shape *shape, double radius[2])
{
    if (!shape)
        return false;
    rmap_shell_radii(shape, radius);
    return radius[0] > 0.3 * radius[1];
}

int rmap_part_count(const struct rmap_accel_object *object)
{
    double radius[2];
    return hollow(object->shape, radius) ? SECTORS : 1;
}

void rmap_part_bounds(const struct rmap_accel_object *object, int part, struct rmap_vec3 *lower,
                      struct rmap_vec3 *upper)
{
    double radius[2];
    *lower = object->lower;
    *upper = object->upper;
    if (!hollow(object->shape, radius))
        return;
    for (int k = 0; k < 4; k++) {
        double angle = 2 * RMAP_PI / SECTORS * (part + k % 2);
        double x = radius[k / 2] * cos(angle), y = radius[k / 2] * sin(angle);
        lower->x = k == 0 ? x : rmap_lesser(lower->x, x);
        lower->y = k == 0 ? y : rmap_lesser(lower->y, y);
        upper->x = k == 0 ? x : rmap_greater(upper->x, x);
        upper->y = k == 0 ? y : rmap_greater(upper->y, y);
    }
}
