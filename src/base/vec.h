/* SPDX-License-Identifier: MIT
 *
 * Vectors and affine maps in double precision. An affine map is stored row by row,
 * x' = m x + t, as a scene file's `matrix: 12 numbers` is.
 */
#ifndef RMAP_VEC_H
#define RMAP_VEC_H

#include <math.h>
#include <stdbool.h>

#define RMAP_PI 3.14159265358979323846

struct rmap_vec3 {
    double x, y, z;
};

struct rmap_affine {
    double m[3][3];
    struct rmap_vec3 t;
};

/* fmin and fmax without a call; b where either is NaN */
static inline double rmap_min(double a, double b)
{
    return a < b ? a : b;
}

static inline double rmap_max(double a, double b)
{
    return a > b ? a : b;
}

static inline struct rmap_vec3 rmap_vec3(double x, double y, double z)
{
    return (struct rmap_vec3){x, y, z};
}

static inline struct rmap_vec3 rmap_vec3_of(const float v[3])
{
    return rmap_vec3((double)v[0], (double)v[1], (double)v[2]);
}

static inline struct rmap_vec3 rmap_add(struct rmap_vec3 a, struct rmap_vec3 b)
{
    return rmap_vec3(a.x + b.x, a.y + b.y, a.z + b.z);
}

static inline struct rmap_vec3 rmap_sub(struct rmap_vec3 a, struct rmap_vec3 b)
{
    return rmap_vec3(a.x - b.x, a.y - b.y, a.z - b.z);
}

static inline struct rmap_vec3 rmap_scale(struct rmap_vec3 a, double s)
{
    return rmap_vec3(a.x * s, a.y * s, a.z * s);
}

/* a + s b */
static inline struct rmap_vec3 rmap_axpy(double s, struct rmap_vec3 b, struct rmap_vec3 a)
{
    return rmap_vec3(a.x + s * b.x, a.y + s * b.y, a.z + s * b.z);
}

static inline double rmap_dot(struct rmap_vec3 a, struct rmap_vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline struct rmap_vec3 rmap_cross(struct rmap_vec3 a, struct rmap_vec3 b)
{
    return rmap_vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

static inline double rmap_length(struct rmap_vec3 a)
{
    return sqrt(rmap_dot(a, a));
}

static inline struct rmap_vec3 rmap_normalize(struct rmap_vec3 a)
{
    return rmap_scale(a, 1.0 / rmap_length(a));
}

/* Componentwise least and greatest. */
static inline struct rmap_vec3 rmap_least(struct rmap_vec3 a, struct rmap_vec3 b)
{
    return rmap_vec3(fmin(a.x, b.x), fmin(a.y, b.y), fmin(a.z, b.z));
}

static inline struct rmap_vec3 rmap_greatest(struct rmap_vec3 a, struct rmap_vec3 b)
{
    return rmap_vec3(fmax(a.x, b.x), fmax(a.y, b.y), fmax(a.z, b.z));
}

static inline struct rmap_affine rmap_affine_identity(void)
{
    return (struct rmap_affine){{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}};
}

/* The linear part applied: directions, edges. */
static inline struct rmap_vec3 rmap_affine_vector(const struct rmap_affine *a, struct rmap_vec3 v)
{
    return rmap_vec3(a->m[0][0] * v.x + a->m[0][1] * v.y + a->m[0][2] * v.z,
                     a->m[1][0] * v.x + a->m[1][1] * v.y + a->m[1][2] * v.z,
                     a->m[2][0] * v.x + a->m[2][1] * v.y + a->m[2][2] * v.z);
}

static inline struct rmap_vec3 rmap_affine_point(const struct rmap_affine *a, struct rmap_vec3 p)
{
    return rmap_add(rmap_affine_vector(a, p), a->t);
}

/* The transposed linear part applied. With the inverse map of an instance, this carries its
 * local normals to the world (unnormalised); a mirror keeps the front side the front side. */
static inline struct rmap_vec3 rmap_affine_transposed(const struct rmap_affine *a,
                                                      struct rmap_vec3 v)
{
    return rmap_vec3(a->m[0][0] * v.x + a->m[1][0] * v.y + a->m[2][0] * v.z,
                     a->m[0][1] * v.x + a->m[1][1] * v.y + a->m[2][1] * v.z,
                     a->m[0][2] * v.x + a->m[1][2] * v.y + a->m[2][2] * v.z);
}

/* outer after inner */
struct rmap_affine rmap_affine_compose(const struct rmap_affine *outer,
                                       const struct rmap_affine *inner);

/* Carries a quadratic form p.M p of where the map leads to where it comes from: L^T M L, L its
 * linear part. */
void rmap_affine_congruent(const struct rmap_affine *a, double form[3][3]);

double rmap_affine_determinant(const struct rmap_affine *a);

/* Root of the sum of the squared entries of m: no vector is stretched by more. */
double rmap_affine_norm(const struct rmap_affine *a);

/* False, with *inverse unset, when the map is singular or it, its determinant or the inverse is not
 * finite: scales of about 1e-102 and 1e102 are the last that have one. */
bool rmap_affine_invert(const struct rmap_affine *a, struct rmap_affine *inverse);

/* Scale first, then rotations about x, y, z in that order (degrees), then translation. */
struct rmap_affine rmap_affine_placement(struct rmap_vec3 scale, struct rmap_vec3 rotate_deg,
                                         struct rmap_vec3 at);

/* A right-handed frame with its z axis along `axis` (any length but 0) and its origin at `at`;
 * x is the projection of the first world axis (X, Y, Z) that is not within 26 degrees of
 * `axis`. For sources, whose shapes need a frame but no handed coordinates. */
struct rmap_affine rmap_affine_frame(struct rmap_vec3 axis, struct rmap_vec3 at);

/* Two unit vectors that form a right-handed orthonormal basis with unit n (Duff et al. 2017,
 * JCGT 6(1), "Building an orthonormal basis, revisited"). */
static inline void rmap_basis(struct rmap_vec3 n, struct rmap_vec3 *u, struct rmap_vec3 *v)
{
    double sign = copysign(1.0, n.z);
    double a = -1.0 / (sign + n.z);
    double b = n.x * n.y * a;
    *u = rmap_vec3(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x);
    *v = rmap_vec3(b, sign + n.y * n.y * a, -n.y);
}

#endif
