/* SPDX-License-Identifier: MIT
 *
 * Where a ray meets the plane of a triangle that it is known to cross: the corners are sheared so
 * that it runs along one axis, that of its direction's largest component (Woop, Benthin and Wald
 * 2013, JCGT 2(1), "Watertight ray/triangle intersection").
 */
#ifndef RMAP_TRIANGLE_H
#define RMAP_TRIANGLE_H

#include "base/vec.h"

/* The axes in order, with the last one at the end. */
static inline struct rmap_vec3 rmap_triangle_turned(double z_last, double x_last,
                                                    struct rmap_vec3 v)
{
    double x = x_last > 0.0 ? v.y : v.z, y = x_last > 0.0 ? v.z : v.x;
    double z = x_last > 0.0 ? v.x : v.y;
    return rmap_vec3(z_last > 0.0 ? v.x : x, z_last > 0.0 ? v.y : y, z_last > 0.0 ? v.z : z);
}

/* Distance; *point: on the triangle; *normal: not of length 1. */
static inline double rmap_triangle_meet(struct rmap_vec3 a, struct rmap_vec3 b, struct rmap_vec3 c,
                                        struct rmap_vec3 from, struct rmap_vec3 d,
                                        struct rmap_vec3 *point, struct rmap_vec3 *normal)
{
    double x_size = fabs(d.x), y_size = fabs(d.y), z_size = fabs(d.z);
    double x_last = x_size > y_size ? 1.0 : 0.0;
    double z_last = z_size > (x_last > 0.0 ? x_size : y_size) ? 1.0 : 0.0;
    struct rmap_vec3 way = rmap_triangle_turned(z_last, x_last, d);
    struct rmap_vec3 p = rmap_triangle_turned(z_last, x_last, rmap_sub(a, from));
    struct rmap_vec3 q = rmap_triangle_turned(z_last, x_last, rmap_sub(b, from));
    struct rmap_vec3 r = rmap_triangle_turned(z_last, x_last, rmap_sub(c, from));
    double scale = 1 / way.z, shear_x = way.x * scale, shear_y = way.y * scale;
    double px = p.x - shear_x * p.z, py = p.y - shear_y * p.z;
    double qx = q.x - shear_x * q.z, qy = q.y - shear_y * q.z;
    double rx = r.x - shear_x * r.z, ry = r.y - shear_y * r.z;
    double area_p = qx * ry - qy * rx, area_q = rx * py - ry * px, area_r = px * qy - py * qx;
    double sum = area_p + area_q + area_r;
    double w0 = area_p / sum, w1 = area_q / sum, w2 = area_r / sum;
    struct rmap_vec3 e1 = rmap_sub(b, a), e2 = rmap_sub(c, a);
    *point = rmap_axpy(w2, e2, rmap_axpy(w1, e1, a));
    *normal = rmap_cross(e1, e2);
    return (w0 * p.z + w1 * q.z + w2 * r.z) * scale;
}

#endif
