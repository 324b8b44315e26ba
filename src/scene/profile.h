/* SPDX-License-Identifier: MIT
 *
 * Intensity about an axis as a table of the angle to it.
 */
#ifndef RMAP_PROFILE_H
#define RMAP_PROFILE_H

#include <stddef.h>

#include "base/status.h"

/* Intensity is linear in 1 - cos(angle) between knots. */
struct rmap_profile_knot {
    double one_minus_cos;
    double intensity; /* of unit flux, 1/sr */
    double below;     /* share of the flux at smaller angles: from 0 to 1 */
};

struct rmap_profile {
    struct rmap_profile_knot *knot;
    size_t n;
};

/* From intensities of any unit, value[n] >= 0 at angle_deg[n], increasing from 0 to 180; between
 * them the intensity is linear in the angle (within knots half a degree apart), and there is none
 * outside. RMAP_INPUT if there is no light; *profile is the caller's to finish. */
enum rmap_status rmap_profile_init(const double *angle_deg, const double *value, size_t n,
                                   struct rmap_profile *profile, struct rmap_error *err);
void rmap_profile_fini(struct rmap_profile *profile);

/* Of knots with an intensity in any unit: their flux in that unit, which is divided out; fills
 * `below`. 0: there is no light. */
double rmap_profile_sum(struct rmap_profile *profile);

/* The first of the two knots that such an angle lies between. */
size_t rmap_profile_find(const struct rmap_profile *profile, double one_minus_cos);

/* 1 - cos(angle) below which the share u in (0, 1) of the flux lies: with uniform u, of a random
 * ray. The same bits everywhere, as src/compact finds it again. */
double rmap_profile_draw(const struct rmap_profile *profile, double u);

/* 1/sr, of unit flux. */
double rmap_profile_intensity(const struct rmap_profile *profile, double one_minus_cos);

#endif
