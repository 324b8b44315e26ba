/* SPDX-License-Identifier: MIT
 *
 * The colour along a path: shares of the channels, weighed by the probability of what happened
 * (trace/interact.c has the physics), on the channels that are still live.
 */
#ifndef RMAP_RETRACE_COLOUR_H
#define RMAP_RETRACE_COLOUR_H

#include "compact/model.h"

void rmap_light_begin(const struct rmap_compact_model *model, int32_t source, int channel,
                      struct rmap_compact_light *light);
void rmap_light_set(const uint16_t *quantised, int n_channel, struct rmap_compact_light *light);
void rmap_light_quantise(int n_channel, struct rmap_compact_light *light);

/* A segment of this length through an absorbing medium: how far the light came on it. */
double rmap_light_absorb(const struct rmap_medium *medium, uint64_t seed, uint64_t ray,
                         uint32_t step, double length, bool absorbed,
                         struct rmap_compact_light *light);

void rmap_light_meet(const struct rmap_encounter *encounter, struct rmap_compact_light *light);

#endif
