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

/* Weight (portion/weight.h) of light that was emitted on one channel and is on another now. */
double rmap_weight_after(const struct rmap_scene *scene, int first, int now);

#endif
