/* SPDX-License-Identifier: MIT
 *
 * One ray after the other traced again, each along its path. Predictions and truth meet at every
 * number: what differs leads the ray on from the truth.
 */
#ifndef RMAP_RETRACE_H
#define RMAP_RETRACE_H

#include "compact/model.h"

/* What a segment starts on; -1: nothing, or no triangle that is known. */
struct rmap_left {
    int32_t object, primitive;
};

/* False when there is no such surface; *facing is then unset. */
bool rmap_facing_find(const struct rmap_compact_model *model, int32_t object, int32_t primitive,
                      const struct rmap_left *left, struct rmap_vec3 origin,
                      struct rmap_vec3 direction, struct rmap_facing *facing);

/* All of them from a portion's columns, colours followed. channel: as above. */
struct rmap_retrace rmap_retrace_of(const struct rmap_compact_model *model,
                                    const struct rmap_lane_header *header,
                                    const struct rmap_portion *portion, const uint8_t *channel,
                                    struct rmap_lane *lane);

/* One ray, whose rows begin at those given. Rays must come in order. */
void rmap_retrace(const struct rmap_retrace *retrace, size_t ray, size_t first_segment,
                  size_t first_registration);

void rmap_departure_find(const struct rmap_compact_model *model, uint64_t seed, uint64_t ray,
                         int32_t source, struct rmap_departure *departure);

void rmap_crossing_find(const struct rmap_detector *detector,
                        const struct rmap_compact_segment *segment, struct rmap_crossing *crossing);

#endif
