/* SPDX-License-Identifier: MIT
 *
 * Directions behind a surface. Without branches, so that loops over many rays become vector
 * instructions; the normal is a unit vector towards the light.
 */
#ifndef RMAP_TURN_H
#define RMAP_TURN_H

#include "formula/azimuth.h"

static inline struct rmap_vec3 rmap_reflected(struct rmap_vec3 direction, struct rmap_vec3 normal)
{
    double cosine = rmap_dot(direction, normal);
    return rmap_normalize(rmap_axpy(-2.0 * cosine, normal, direction));
}

/* Snell's law from the tangential part, whose sine keeps its digits at any angle; of length 1 as it
 * stands. *total: 1 at total reflection, where the direction means nothing, else 0. */
static inline struct rmap_vec3 rmap_refracted(struct rmap_vec3 direction, struct rmap_vec3 normal,
                                              double n1, double n2, double *total)
{
    double cosine = rmap_dot(direction, normal), same = n1 == n2 ? 1.0 : 0.0;
    struct rmap_vec3 tangent = rmap_scale(rmap_axpy(-cosine, normal, direction), n1 / n2);
    double cos2_t = 1.0 - rmap_dot(tangent, tangent);
    struct rmap_vec3 bent = rmap_axpy(-sqrt(cos2_t), normal, tangent);
    *total = cos2_t > 0.0 ? 0.0 : 1.0 - same;
    return rmap_vec3(same > 0.0 ? direction.x : bent.x, same > 0.0 ? direction.y : bent.y,
                     same > 0.0 ? direction.z : bent.z);
}

/* Cosine-weighted about the normal, u and v uniform in (0, 1): a uniform point of the unit disc,
 * lifted to the sphere; unit to 4e-16. */
static inline struct rmap_vec3 rmap_diffused(struct rmap_vec3 normal, double u, double v)
{
    struct rmap_vec3 x, y;
    double r = sqrt(u), cosine, sine;
    rmap_basis(normal, &x, &y);
    rmap_azimuth(v, &cosine, &sine);
    struct rmap_vec3 plane = rmap_axpy(r * cosine, x, rmap_scale(y, r * sine));
    return rmap_axpy(sqrt(1.0 - u), normal, plane);
}

#endif
