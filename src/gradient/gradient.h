/* SPDX-License-Identifier: MIT
 *
 * A gradient medium in place: a field, and the frame it stands in. Two bodies filled with the same
 * medium are two of these; `/segment/medium` and criteria see one medium.
 */
#ifndef RMAP_GRADIENT_H
#define RMAP_GRADIENT_H

#include <stdint.h>

#include "base/vec.h"
#include "gradient/field.h"

enum rmap_scheme {
    RMAP_SCHEME_ADAPTIVE, /* the default: in closed form where the field has one, else INTEGRATED */
    RMAP_SCHEME_SHARMA,   /* three evaluations, order 4, the step rule between step_min and step_max
                             (Sharma, Kumar, Ghatak 1982, doi:10.1364/AO.21.000984) */
    RMAP_SCHEME_SHARMA_FIXED, /* the same with a fixed step */
    RMAP_SCHEME_INTEGRATED    /* error-controlled, dense output */
};

/* How light is traced through a medium. Lengths in the scene's unit; 0: chosen from the size of
 * what the medium fills (rmap_scene_finish). */
struct rmap_curve_options {
    enum rmap_scheme scheme;
    double tolerance; /* of positions on the curve and of boundaries met; default 1e-9 x size */
    double sag;       /* most that a chord tested against the scene may leave the curve where no
                         surface is near; default 1e-2 x size */
    double polyline; /* most that the recorded points' polyline may leave it; default 1e-3 x size */
    double step_min, step_max; /* SHARMA: geometric lengths; default 1e-4, 1e-2 x size */
    double step;               /* SHARMA_FIXED; default 1e-2 x size */
    double amplitude;          /* SHARMA: of the directional derivative of n; default 1 / size */
    uint64_t max_steps;        /* per segment, then the ray ends with `limit`; default 1,000,000 */
    double first_6, first_8;   /* what a first step may be of the length over which the field is
                                  like a polynomial, by either pair: rmap_curve_prepare; 0: worked
                                  out for every curve anew */
};

struct rmap_gradient {
    int32_t medium;
    const struct rmap_field *field;   /* the medium's */
    struct rmap_field *const *beside; /* the medium's; NULL: no dispersion */
    struct rmap_affine to_world, to_local;
    double size;                       /* diameter of what it fills */
    struct rmap_curve_options options; /* none of them 0 */
};

/* Index and its gradient in the world; false where the field has no value. */
static inline bool rmap_gradient_at(const struct rmap_gradient *gradient, int channel,
                                    struct rmap_vec3 p, double *n, struct rmap_vec3 *slope)
{
    struct rmap_vec3 local;
    if (!rmap_field_at(gradient->field, channel, rmap_affine_point(&gradient->to_local, p), n,
                       &local))
        return false;
    *slope = rmap_affine_transposed(&gradient->to_local, local);
    return true;
}

/* What the two fields beside it are: the medium at wavelengths 1 - this and 1 + this times those of
 * the channels. */
#define RMAP_GRADIENT_BESIDE 1e-4

/* n - wavelength dn/dwavelength at a place in the world, where the index is n; n without
 * dispersion, or where a field has no value. */
static inline double rmap_gradient_group(const struct rmap_gradient *gradient, int channel,
                                         struct rmap_vec3 p, double n)
{
    double of[2];
    struct rmap_vec3 slope, local = rmap_affine_point(&gradient->to_local, p);
    if (!gradient->beside || !rmap_field_at(gradient->beside[0], channel, local, &of[0], &slope) ||
        !rmap_field_at(gradient->beside[1], channel, local, &of[1], &slope))
        return n;
    return n - (of[1] - of[0]) / (2.0 * RMAP_GRADIENT_BESIDE);
}

#endif
