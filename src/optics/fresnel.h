/* SPDX-License-Identifier: MIT
 *
 * Fresnel reflectances (Born & Wolf, Principles of Optics, 7th ed., 1.5.2 and 14.2; metal with
 * complex index n + i k).
 */
#ifndef RMAP_FRESNEL_H
#define RMAP_FRESNEL_H

#include <stdbool.h>

struct rmap_fresnel {
    double rs, rp; /* power reflectances of the two polarisations */
    double cos_t;  /* cosine of the refracted angle, >= 0; 0 at total reflection */
    bool total;    /* total internal reflection; rs = rp = 1 */
};

/* From index n1 into n2, cos_i in [0, 1]. */
struct rmap_fresnel rmap_fresnel_dielectric(double n1, double n2, double cos_i);

/* Unpolarised reflectance, (rs + rp) / 2, of a metal n + i k seen from index n1. */
double rmap_fresnel_metal(double n1, double n, double k, double cos_i);

#endif
