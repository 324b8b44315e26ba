/* SPDX-License-Identifier: MIT
 *
 * What batches know beforehand of objects and of the segments that end on them.
 */
#ifndef RMAP_BATCH_GUIDE_H
#define RMAP_BATCH_GUIDE_H

#include "compact/batch.h"

/* What is known of a flat object, of any object's segments, and of those that meet none
 * beforehand. */
void rmap_batch_set_flat(struct rmap_compact_object *object);
void rmap_batch_guide(const struct rmap_scene *scene, const struct rmap_compact_object *object,
                      struct rmap_compact_guide *guide);
void rmap_batch_guide_out(const struct rmap_compact_model *model, struct rmap_compact_guide *guide);

/* Queue and flags, as rmap_compact_guide has them, of a segment of this kind. */
uint32_t rmap_batch_step(const struct rmap_compact_guide *guide, uint32_t kind, uint32_t event);

#endif
