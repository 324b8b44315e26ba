/* SPDX-License-Identifier: MIT
 *
 * A field's gradient and Laplacian against differences. Include after cmocka.h.
 */
#ifndef FIELD_CHECK_H
#define FIELD_CHECK_H

#include "gradient/field.h"
#include "near.h"

static inline double field_value(const struct rmap_field *field, int channel, struct rmap_vec3 p)
{
    double value;
    struct rmap_vec3 gradient;
    assert_true(rmap_field_scalar(field, channel, p, &value, &gradient));
    return value;
}

/* Fourth-order central differences along an axis. */
static inline double field_slope(const struct rmap_field *field, int channel, struct rmap_vec3 p,
                                 struct rmap_vec3 axis, double h)
{
    double near_by = field_value(field, channel, rmap_axpy(h, axis, p)) -
                     field_value(field, channel, rmap_axpy(-h, axis, p));
    double far_off = field_value(field, channel, rmap_axpy(2 * h, axis, p)) -
                     field_value(field, channel, rmap_axpy(-2 * h, axis, p));
    return (8.0 * near_by - far_off) / (12.0 * h);
}

static inline double field_second(const struct rmap_field *field, int channel, struct rmap_vec3 p,
                                  struct rmap_vec3 axis, double h)
{
    double near_by = field_value(field, channel, rmap_axpy(h, axis, p)) +
                     field_value(field, channel, rmap_axpy(-h, axis, p));
    double far_off = field_value(field, channel, rmap_axpy(2 * h, axis, p)) +
                     field_value(field, channel, rmap_axpy(-2 * h, axis, p));
    return (16.0 * near_by - far_off - 30.0 * field_value(field, channel, p)) / (12.0 * h * h);
}

/* h: a small part of the lengths over which the field changes; `scale`: the size of its changes
 * over a length 1, so that tolerances are relative. */
static inline void field_check(const struct rmap_field *field, int channel, struct rmap_vec3 p,
                               double h, double scale)
{
    double value, laplacian;
    struct rmap_vec3 gradient;
    const struct rmap_vec3 x = {1, 0, 0}, y = {0, 1, 0}, z = {0, 0, 1};
    assert_true(rmap_field_scalar(field, channel, p, &value, &gradient));
    assert_near(gradient.x, field_slope(field, channel, p, x, h), 1e-8 * scale);
    assert_near(gradient.y, field_slope(field, channel, p, y, h), 1e-8 * scale);
    assert_near(gradient.z, field_slope(field, channel, p, z, h), 1e-8 * scale);
    assert_true(rmap_field_laplacian(field, channel, p, &laplacian));
    double expected = field_second(field, channel, p, x, h) +
                      field_second(field, channel, p, y, h) + field_second(field, channel, p, z, h);
    assert_near(laplacian, expected, 1e-5 * fmax(scale, fabs(expected)));
}

/* At a handful of places within `reach` of the origin, none of them on an axis but the last. */
static inline void field_check_within(const struct rmap_field *field, int channel, double reach)
{
    static const struct rmap_vec3 place[] = {{0.31, -0.22, 0.4},
                                             {-0.5, 0.1, 0.05},
                                             {0.02, 0.6, -0.3},
                                             {-0.1, -0.2, -0.55},
                                             {0.0, 0.0, 0.4}};
    for (size_t i = 0; i < sizeof place / sizeof place[0]; i++)
        field_check(field, channel, rmap_scale(place[i], reach), 2e-3 * reach, 1.0 / reach);
}

#endif
