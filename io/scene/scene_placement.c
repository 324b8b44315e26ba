/* SPDX-License-Identifier: MIT
 *
 * `at`, `rotate`, `scale`, `matrix`.
 */
#include "io/scene/scene_placement.h"

#include <math.h>

#include "io/scene/scene_values.h"

static bool read_scale(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                       struct rmap_vec3 *scale)
{
    double s[3] = {1, 1, 1};
    size_t n = 0;
    const struct rmap_yaml_node *node = rmap_yaml_get(map, "scale");
    if (!rmap_reader_numbers(reader, map, "scale", RMAP_OPTIONAL, &rmap_range_any, 1, 3, s, &n))
        return false;
    if (n == 2) {
        rmap_reader_error(reader, node, "'scale' must be a number or a list of 3 numbers");
        return false;
    }
    if (n == 1)
        s[1] = s[2] = s[0];
    *scale = rmap_vec3(s[0], s[1], s[2]);
    return true;
}

static bool read_matrix(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                        struct rmap_affine *placement)
{
    static const char *const other[] = {"at", "rotate", "scale", "direction"};
    double m[12];
    size_t n = 0;
    bool good = true;
    for (size_t i = 0; i < RMAP_COUNT(other); i++) {
        const struct rmap_yaml_node *node = rmap_yaml_get(map, other[i]);
        if (!node)
            continue;
        rmap_reader_error(reader, node, "give 'matrix' or '%s', not both", other[i]);
        good = false;
    }
    good &=
        rmap_reader_numbers(reader, map, "matrix", RMAP_OPTIONAL, &rmap_range_any, 12, 12, m, &n);
    if (!good)
        return false;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            placement->m[i][j] = m[4 * i + j];
    placement->t = rmap_vec3(m[3], m[7], m[11]);
    return true;
}

/* Not too large or too small for an inverse, but without one. */
static bool flattens(const struct rmap_affine *placement)
{
    struct rmap_affine unit = *placement;
    double most = 0;
    for (int k = 0; k < 9; k++)
        most = fmax(most, fabs(placement->m[k / 3][k % 3]));
    for (int k = 0; k < 9; k++)
        unit.m[k / 3][k % 3] /= most;
    return !(fabs(rmap_affine_determinant(&unit)) > 0);
}

bool rmap_reader_placement(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                           struct rmap_affine *placement)
{
    struct rmap_affine inverse;
    const struct rmap_yaml_node *matrix = rmap_yaml_get(map, "matrix");
    *placement = rmap_affine_identity();
    if (matrix) {
        if (!read_matrix(reader, map, placement))
            return false;
    } else {
        struct rmap_vec3 scale = {1, 1, 1}, rotate = {0, 0, 0}, at = {0, 0, 0};
        bool good = read_scale(reader, map, &scale);
        good &= rmap_reader_vec3(reader, map, "rotate", &rmap_range_angle, &rotate);
        good &= rmap_reader_vec3(reader, map, "at", &rmap_range_length, &at);
        if (!good)
            return false;
        *placement = rmap_affine_placement(scale, rotate, at);
    }
    if (rmap_affine_invert(placement, &inverse))
        return true;
    const struct rmap_yaml_node *scale = rmap_yaml_get(map, "scale");
    const struct rmap_yaml_node *at = matrix ? matrix : scale ? scale : map;
    if (flattens(placement))
        rmap_reader_error(reader, at, "this transform is singular: it flattens its object; %s",
                          matrix ? "the 3 x 3 part of the matrix must have an inverse"
                                 : "no scale may be 0");
    else
        rmap_reader_error(reader, at,
                          "this transform is too small, too large or too far away to be inverted: "
                          "scales must lie between 1e-100 and 1e100, positions below 1e150");
    *placement = rmap_affine_identity();
    return false;
}

/* Columns x, y, z of the linear part. */
static struct rmap_vec3 column(const struct rmap_affine *a, int j)
{
    return rmap_vec3(a->m[0][j], a->m[1][j], a->m[2][j]);
}

void rmap_placement_axes(const struct rmap_affine *placement, struct rmap_vec3 axis[3])
{
    for (int j = 0; j < 3; j++)
        axis[j] = rmap_normalize(column(placement, j));
}

struct rmap_affine rmap_placement_rigid(const struct rmap_affine *placement)
{
    struct rmap_vec3 x, y, z = rmap_normalize(column(placement, 2));
    x = column(placement, 0);
    x = rmap_normalize(rmap_axpy(-rmap_dot(x, z), z, x));
    y = rmap_cross(z, x);
    if (rmap_dot(y, column(placement, 1)) < 0)
        y = rmap_scale(y, -1);
    return (struct rmap_affine){{{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}}, placement->t};
}

static double component(struct rmap_vec3 v, int axis)
{
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

void rmap_placement_plane(struct rmap_vec3 axis, struct rmap_vec3 *x, struct rmap_vec3 *y)
{
    int first = 0;
    while (first < 2 && !(fabs(component(axis, first)) < 0.9))
        first++;
    struct rmap_vec3 world = rmap_vec3(first == 0, first == 1, first == 2);
    *x = rmap_normalize(rmap_axpy(-rmap_dot(world, axis), axis, world));
    *y = rmap_normalize(rmap_cross(axis, *x));
    int second = first == 0 ? 1 : 0, third = first == 2 ? 1 : 2;
    double a = component(*y, second), b = component(*y, third);
    double sign = (fabs(a) >= fabs(b) ? a : b) < 0 ? -1 : 1;
    /* Adding 0 makes -0 a plain 0. */
    *y = rmap_add(rmap_scale(*y, sign), rmap_vec3(0, 0, 0));
}
