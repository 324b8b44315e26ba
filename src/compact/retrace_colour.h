/* SPDX-License-Identifier: MIT
 *
 * The colour along a path: shares of the channels, weighed by the probability of what happened
 * (trace/interact.c has the physics), on the channels that are still live.
 */
#ifndef RMAP_RETRACE_COLOUR_H
#define RMAP_RETRACE_COLOUR_H

#include "base/rng.h"
#include "compact/model.h"

void rmap_light_begin(const struct rmap_compact_model *model, int32_t source, int channel,
                      struct rmap_compact_light *light);
void rmap_light_set(const uint16_t *quantised, int n_channel, struct rmap_compact_light *light);
void rmap_light_quantise(int n_channel, struct rmap_compact_light *light);

/* A segment through a medium that absorbs, or scatters. */
struct rmap_inside {
    const struct rmap_medium *medium;
    bool turbid; /* what it scatters is predicted, too: as struct rmap_retrace has it */
    struct rmap_draw draw;
    double length;
    uint32_t event; /* what ended it inside: ABSORB, SCATTER_VOLUME, FLUORESCE; 0: nothing did */
};

/* How far the light came on it. */
double rmap_light_travel(const struct rmap_inside *inside, struct rmap_compact_light *light);

/* The direction behind a segment that SCATTER_VOLUME or FLUORESCE ended, and its light; true: they
 * are of another channel now. */
bool rmap_light_go_on(const struct rmap_inside *inside, int n_channel,
                      struct rmap_compact_light *light, struct rmap_vec3 *direction);

void rmap_light_meet(const struct rmap_encounter *encounter, struct rmap_compact_light *light);

#endif
