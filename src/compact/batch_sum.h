/* SPDX-License-Identifier: MIT
 *
 * Colours and lengths along a ray, once a batch knows its segments.
 */
#ifndef RMAP_BATCH_SUM_H
#define RMAP_BATCH_SUM_H

#include "compact/batch.h"

/* Departures and segments of the next rays. */
void rmap_batch_ready(struct rmap_batch_run *run);

/* What follows from the segments of a ray that has arrived. */
void rmap_batch_sum(struct rmap_batch_run *run, const struct rmap_batch_ray *ray);

#endif
