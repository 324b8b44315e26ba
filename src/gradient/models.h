/* SPDX-License-Identifier: MIT
 *
 * Makers of the analytic index fields that are no polynomials (field_polynomial.h has those).
 * Frames are the field's own; lengths in one unit, the frame's.
 *
 * Parameters are plain structures of doubles, one per channel: [n_channel], n_channel 1 when the
 * channels do not differ, else the scene's. Every maker copies them, checks them (RMAP_INPUT says
 * which is wrong, by its name here) and hands the field over (rmap_field_destroy); fields given to
 * a maker are taken, also when it fails. RMAP_SYSTEM when memory is short.
 */
#ifndef RMAP_MODELS_H
#define RMAP_MODELS_H

#include <stddef.h>

#include "base/status.h"
#include "gradient/field.h"

/* ---- Spheres about the origin, r = |p| ---- */

/* n = n_centre / (1 + (r/radius)^2) */
struct rmap_maxwell {
    double n_centre, radius; /* usual: 2, so that n(radius) = 1 */
};
/* n = n_edge sqrt(2 radius / r - 1): no value at the centre, nor from 2 radius on */
struct rmap_eaton {
    double n_edge, radius;
};
enum rmap_status rmap_field_maxwell(struct rmap_field **field_ret, int n_channel,
                                    const struct rmap_maxwell *parameter,
                                    struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_field_eaton(struct rmap_field **field_ret, int n_channel,
                                  const struct rmap_eaton *parameter,
                                  struct rmap_error *err) RMAP_MUST_USE;

/* ---- Rods about the z axis, rho^2 = x^2 + y^2 ---- */

/* n = n0 sech(alpha rho) */
struct rmap_sech {
    double n0, alpha; /* 1/length */
};

enum rmap_status rmap_field_sech(struct rmap_field **field_ret, int n_channel,
                                 const struct rmap_sech *parameter,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* ---- Atmospheres ---- */

/* n = n_far + refractivity exp(-h / scale_height); h = z (radius 0), or |p| - radius */
struct rmap_exponential {
    double n_far; /* usual: 1 */
    double refractivity, scale_height, radius;
};
enum rmap_status rmap_field_exponential(struct rmap_field **field_ret, int n_channel,
                                        const struct rmap_exponential *parameter,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* Dry air of the U.S. Standard Atmosphere 1976 up to 86 km, with an exponential beyond and below;
 * h as above. */
struct rmap_standard_air {
    double radius;        /* of the ground, in the field's unit; 0: planar, h = z */
    double metre;         /* in the field's unit: 1000 for mm */
    double temperature_k; /* at h = 0; usual: 288.15; the whole column is shifted */
    double pressure_pa;   /* at h = 0; usual: 101325 */
};
enum rmap_status rmap_field_standard_air(struct rmap_field **field_ret, int n_channel,
                                         const double *wavelength_nm,
                                         const struct rmap_standard_air *parameter,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* n over a coordinate, given by points and joined by a cubic spline (C2, natural ends); beyond the
 * points on by its tangent. */
enum rmap_profile_variable {
    RMAP_PROFILE_Z,
    RMAP_PROFILE_RHO, /* sqrt(x^2 + y^2); points from 0 on: even about 0 */
    RMAP_PROFILE_R    /* |p| - radius; with radius 0 as RHO */
};
/* at: [n_point], increasing, n_point >= 2; n: [n_channel][n_point]. */
enum rmap_status rmap_field_profile(struct rmap_field **field_ret, enum rmap_profile_variable s,
                                    double radius, int n_channel, int n_point, const double *at,
                                    const double *n, struct rmap_error *err) RMAP_MUST_USE;

/* ---- Fields made of fields ---- */

/* n of a scalar v that a field gives (any sign: rmap_field_scalar): temperature, density,
 * salinity, concentration. */
enum rmap_index_law {
    RMAP_INDEX_LINEAR,         /* n = n0 + slope v */
    RMAP_INDEX_GLADSTONE_DALE, /* n = 1 + (n0 - 1) v / reference: v a density, n0 at `reference` */
    RMAP_INDEX_AIR, /* v: temperature of dry air, K - zero_k; at pressure_pa (Ciddor 1996, density
                       by the ideal gas) */
    RMAP_INDEX_SEAWATER_SALINITY, /* v: salinity, per mille; at temperature_c (Quan & Fry 1995) */
    RMAP_INDEX_SEAWATER_TEMPERATURE, /* v: temperature, Celsius; at salinity */
    RMAP_INDEX_TABLE /* cubic spline through (at[i], n[i]), beyond them on by its tangent */
};
struct rmap_index_of {
    enum rmap_index_law law;
    double n0, slope;     /* LINEAR, GLADSTONE_DALE */
    double reference;     /* GLADSTONE_DALE: density */
    double pressure_pa;   /* AIR */
    double zero_k;        /* AIR: 0 for v in K, 273.15 for v in Celsius */
    double temperature_c; /* SEAWATER_SALINITY */
    double salinity;      /* SEAWATER_TEMPERATURE */
    int n_point;          /* TABLE: at, n: [n_point], copied; at increasing */
    const double *at, *n;
};
/* wavelength_nm: [n_channel]; parameter: [n_channel], `law` and n_point the same in all. */
enum rmap_status rmap_field_of_scalar(struct rmap_field **field_ret, struct rmap_field *scalar,
                                      int n_channel, const double *wavelength_nm,
                                      const struct rmap_index_of *parameter,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
