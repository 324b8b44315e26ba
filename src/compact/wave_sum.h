/* SPDX-License-Identifier: MIT
 *
 * Colours and lengths along a ray, once a wave knows its legs.
 */
#ifndef RMAP_WAVE_SUM_H
#define RMAP_WAVE_SUM_H

#include "compact/wave.h"

/* Departures and legs of the next rays. */
void rmap_wave_ready(struct rmap_wave_run *run);

/* What follows from the legs of a ray that has arrived. */
void rmap_wave_sum(struct rmap_wave_run *run, const struct rmap_wave_ray *ray);

#endif
