/* SPDX-License-Identifier: MIT
 *
 * Absorption and scattering inside a medium: a free path drawn per segment, and what happens at its
 * end (analog Monte Carlo). Both act over the geometric length, in straight and in curved segments.
 */
#ifndef RMAP_TURBID_H
#define RMAP_TURBID_H

#include "trace/interact.h"

/* How far light gets in an absorbing or scattering medium if no surface comes first. */
struct rmap_free_path {
    double length; /* infinite where the channel drawn is neither absorbed nor scattered */
    double u[4];   /* the segment's random numbers */
};

/* Does the medium absorb or scatter at all? */
static inline bool rmap_medium_participates(const struct rmap_medium *medium)
{
    return medium->absorbing | medium->scattering_at_all;
}

void rmap_free_path_draw(const struct rmap_medium *medium, const struct rmap_draw *draw,
                         const struct rmap_colour *colour, struct rmap_free_path *path);

/* What happened at the end of a segment of this length: RMAP_EVENT_ABSORB or
 * RMAP_EVENT_SCATTER_VOLUME where the free path ended it, else 0. The colour becomes that of the
 * light that did so (Beer-Lambert, per channel). */
uint32_t rmap_free_path_end(const struct rmap_medium *medium, const struct rmap_free_path *path,
                            double length, bool ended, struct rmap_colour *colour);

/* Direction after scattering in the medium. Where its phase function differs between channels, one
 * of the colour's is drawn, and left alone. */
struct rmap_vec3 rmap_scatter(const struct rmap_medium *medium, const struct rmap_draw *draw,
                              struct rmap_colour *colour, struct rmap_vec3 direction);

/* Phase function of a channel at a cosine of the angle between directions, 1/sr. */
double rmap_phase_density(const struct rmap_medium *medium, int channel, double cosine);

#endif
