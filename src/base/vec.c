/* SPDX-License-Identifier: MIT
 *
 * Vectors and affine maps in double precision.
 */
#include "base/vec.h"

struct rmap_affine rmap_affine_compose(const struct rmap_affine *outer,
                                       const struct rmap_affine *inner)
{
    struct rmap_affine result;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            result.m[i][j] = outer->m[i][0] * inner->m[0][j] + outer->m[i][1] * inner->m[1][j] +
                             outer->m[i][2] * inner->m[2][j];
    result.t = rmap_affine_point(outer, inner->t);
    return result;
}

void rmap_affine_congruent(const struct rmap_affine *a, double form[3][3])
{
    double half[3][3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            half[i][j] =
                form[i][0] * a->m[0][j] + form[i][1] * a->m[1][j] + form[i][2] * a->m[2][j];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            form[i][j] =
                a->m[0][i] * half[0][j] + a->m[1][i] * half[1][j] + a->m[2][i] * half[2][j];
}

static struct rmap_vec3 column(const struct rmap_affine *a, int j)
{
    return rmap_vec3(a->m[0][j], a->m[1][j], a->m[2][j]);
}

double rmap_affine_determinant(const struct rmap_affine *a)
{
    return rmap_dot(column(a, 0), rmap_cross(column(a, 1), column(a, 2)));
}

double rmap_affine_norm(const struct rmap_affine *a)
{
    double sum = 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            sum += a->m[i][j] * a->m[i][j];
    return sqrt(sum);
}

bool rmap_affine_invert(const struct rmap_affine *a, struct rmap_affine *inverse)
{
    double det = rmap_affine_determinant(a);
    if (!isfinite(det) || !isfinite(1.0 / det) || !isfinite(rmap_dot(a->t, a->t)))
        return false;
    struct rmap_vec3 row[3] = {rmap_cross(column(a, 1), column(a, 2)),
                               rmap_cross(column(a, 2), column(a, 0)),
                               rmap_cross(column(a, 0), column(a, 1))};
    struct rmap_affine result = rmap_affine_identity();
    for (int i = 0; i < 3; i++) {
        result.m[i][0] = row[i].x / det;
        result.m[i][1] = row[i].y / det;
        result.m[i][2] = row[i].z / det;
        if (!isfinite(result.m[i][0] + result.m[i][1] + result.m[i][2]))
            return false;
    }
    result.t = rmap_scale(rmap_affine_vector(&result, a->t), -1.0);
    if (!isfinite(result.t.x + result.t.y + result.t.z))
        return false;
    *inverse = result;
    return true;
}

static struct rmap_affine rotation(int axis, double degrees)
{
    /* sin and cos from the reduced angle, so that quarter turns are exact */
    double reduced = remainder(degrees, 360.0);
    double c = cos(reduced * (RMAP_PI / 180.0)), s = sin(reduced * (RMAP_PI / 180.0));
    if (fabs(reduced) == 90.0)
        c = 0.0;
    if (fabs(reduced) == 180.0)
        s = 0.0;
    int i = (axis + 1) % 3, j = (axis + 2) % 3;
    struct rmap_affine r = rmap_affine_identity();
    r.m[i][i] = c;
    r.m[i][j] = -s;
    r.m[j][i] = s;
    r.m[j][j] = c;
    return r;
}

struct rmap_affine rmap_affine_placement(struct rmap_vec3 scale, struct rmap_vec3 rotate_deg,
                                         struct rmap_vec3 at)
{
    struct rmap_affine result = rmap_affine_identity();
    result.m[0][0] = scale.x;
    result.m[1][1] = scale.y;
    result.m[2][2] = scale.z;
    const double degrees[3] = {rotate_deg.x, rotate_deg.y, rotate_deg.z};
    for (int axis = 0; axis < 3; axis++) {
        struct rmap_affine r = rotation(axis, degrees[axis]);
        result = rmap_affine_compose(&r, &result);
    }
    result.t = at;
    return result;
}

struct rmap_affine rmap_affine_frame(struct rmap_vec3 axis, struct rmap_vec3 at)
{
    const double parallel = 0.9; /* cos 26 degrees */
    struct rmap_vec3 z = rmap_normalize(axis);
    struct rmap_vec3 world = fabs(z.x) < parallel ? rmap_vec3(1, 0, 0) : rmap_vec3(0, 1, 0);
    struct rmap_vec3 x = rmap_normalize(rmap_axpy(-rmap_dot(world, z), z, world));
    struct rmap_vec3 y = rmap_cross(z, x);
    return (struct rmap_affine){{{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}}, at};
}
