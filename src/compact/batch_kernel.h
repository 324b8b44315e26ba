/* SPDX-License-Identifier: MIT
 *
 * The arithmetic of retrace.c and step.h for a pack of rays, without branches, so that
 * the compiler turns each loop into vector instructions. Every number goes through the same
 * operations in the same order as there; cases that branch there are marked odd.
 */
#ifndef RMAP_BATCH_KERNEL_H
#define RMAP_BATCH_KERNEL_H

#include "compact/batch.h"

/* Positions and directions out of the rays; and after a segment back into `to`, with
 * its length and cosine. */
void rmap_batch_load(struct rmap_batch_pack *pack);
void rmap_batch_store(const struct rmap_batch_pack *pack,
                      struct rmap_batch_ray *const to[RMAP_BATCH_WIDTH]);

/* Ends of n segments into these rows of the columns, which may be NULL. */
void rmap_batch_note(const struct rmap_batch_pack *pack, const size_t row[RMAP_BATCH_WIDTH],
                     size_t n, float *position, int16_t *normal);

/* The same of a full pack, of segments that are none their rays' last: what comes after a row is
 * written later. */
void rmap_batch_note_on(const struct rmap_batch_pack *pack, const size_t row[RMAP_BATCH_WIDTH],
                        float *position, int16_t *normal);

/* To the end of the segments, which are all of this kind; meshes: triangles that exist.
 */
void rmap_batch_meet_nothing(const struct rmap_scene *scene, struct rmap_batch_pack *pack);
void rmap_batch_meet_quadrics(bool own, double behind, struct rmap_batch_pack *pack);
void rmap_batch_meet_flats(struct rmap_batch_pack *pack);
void rmap_batch_meet_meshes(struct rmap_batch_pack *pack);

void rmap_batch_turn(enum rmap_turn turn, uint64_t seed, struct rmap_batch_pack *pack);

/* How rays [first, end) set out, at most RMAP_BATCH_AHEAD. */
void rmap_batch_depart(const struct rmap_retrace *r, size_t first, size_t end,
                       struct rmap_departure *departure);

#endif
