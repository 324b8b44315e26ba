/* SPDX-License-Identifier: MIT
 *
 * Light that a medium absorbs and gives back at another wavelength: fluorescence and
 * phosphorescence, photon by photon.
 */
#ifndef RMAP_LUMINESCENCE_H
#define RMAP_LUMINESCENCE_H

#include "base/rng.h"
#include "scene/scene.h"

struct rmap_reemission {
    int channel;
    double delay_ns;
};

/* Of light of one channel that was absorbed inside the medium: does one of its species give it
 * back? Which of its absorbers took it is drawn by their shares, then by the yield, then the
 * channel by the emission spectrum and the delay by the lifetimes. *back: if true. */
bool rmap_reemit(const struct rmap_medium *medium, int n_channel, const struct rmap_draw *draw,
                 int channel, struct rmap_reemission *back);

/* All directions alike. */
struct rmap_vec3 rmap_reemit_direction(const struct rmap_draw *draw);

/* The nearest multiple of 2^-21 from 0 to 1024: sums of such are exact, in whatever order 2^21 rays
 * of the greatest weight, or 2^31 of about 1, come. */
static inline double rmap_weight_round(double weight)
{
    const double unit = 1 << 21;
    return weight < 1024.0 ? (double)(int64_t)(weight * unit + 0.5) / unit : 1024.0;
}

/* Weight, so rounded, of light that was emitted on one channel and is on another now. */
double rmap_weight_after(const struct rmap_scene *scene, int first, int now);

#endif
