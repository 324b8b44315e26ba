/* SPDX-License-Identifier: MIT
 *
 * Fresnel reflectances (Born & Wolf, Principles of Optics, 7th ed., 1.5.2 and 14.2; metal with
 * complex index n + i k).
 */
#ifndef RMAP_FRESNEL_H
#define RMAP_FRESNEL_H

#include <math.h>
#include <stdbool.h>

struct rmap_fresnel {
    double rs, rp; /* power reflectances of the two polarisations */
    double cos_t;  /* cosine of the refracted angle, >= 0; 0 at total reflection */
    bool total;    /* total internal reflection; rs = rp = 1 */
};

/* From index n1 into n2, cos_i in [0, 1]. */
static inline struct rmap_fresnel rmap_fresnel_dielectric(double n1, double n2, double cos_i)
{
    if (n1 == n2) /* also at grazing incidence, where the formulas give 0/0 */
        return (struct rmap_fresnel){0.0, 0.0, cos_i, false};
    double eta = n1 / n2;
    double sin2_t = eta * eta * (1.0 - cos_i * cos_i);
    if (sin2_t >= 1.0)
        return (struct rmap_fresnel){1.0, 1.0, 0.0, true};
    double cos_t = sqrt(1.0 - sin2_t);
    double s = n1 * cos_i + n2 * cos_t, p = n2 * cos_i + n1 * cos_t;
    double both = 1.0 / (s * p); /* one division for the two quotients */
    double rs = (n1 * cos_i - n2 * cos_t) * p * both;
    double rp = (n2 * cos_i - n1 * cos_t) * s * both;
    return (struct rmap_fresnel){rs * rs, rp * rp, cos_t, false};
}

/* Unpolarised reflectance, (rs + rp) / 2, of a metal n + i k seen from index n1. */
double rmap_fresnel_metal(double n1, double n, double k, double cos_i);

/* The same without hypot, which rounds in another way where it is another library's: the same bits
 * everywhere, as what compact maps are decoded with must be. The tracer takes the one above. */
double rmap_fresnel_metal_portable(double n1, double n, double k, double cos_i);

#endif
