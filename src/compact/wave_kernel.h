/* SPDX-License-Identifier: MIT
 *
 * The arithmetic of retrace.c and step.h for a pack of rays, without branches, so that
 * the compiler turns each loop into vector instructions. Every number goes through the same
 * operations in the same order as there; cases that branch there are marked odd.
 */
#ifndef RMAP_WAVE_KERNEL_H
#define RMAP_WAVE_KERNEL_H

#include "compact/wave.h"

/* Positions and directions out of the rays; and after a leg back into `to`, with
 * its length and cosine. */
void rmap_wave_load(struct rmap_wave_pack *pack);
void rmap_wave_store(const struct rmap_wave_pack *pack,
                     struct rmap_wave_ray *const to[RMAP_WAVE_WIDTH]);

/* Ends of n legs into these rows of the columns, which may be NULL. */
void rmap_wave_note(const struct rmap_wave_pack *pack, const size_t row[RMAP_WAVE_WIDTH], size_t n,
                    float *position, int16_t *normal);

/* The same of a full pack, of legs that are none their rays' last: what comes after a row is
 * written later. */
void rmap_wave_note_on(const struct rmap_wave_pack *pack, const size_t row[RMAP_WAVE_WIDTH],
                       float *position, int16_t *normal);

/* To the end of the legs, which are all of this kind; meshes: triangles that exist.
 */
void rmap_wave_meet_nothing(const struct rmap_scene *scene, struct rmap_wave_pack *pack);
void rmap_wave_meet_quadrics(bool own, double behind, struct rmap_wave_pack *pack);
void rmap_wave_meet_flats(struct rmap_wave_pack *pack);
void rmap_wave_meet_meshes(struct rmap_wave_pack *pack);

void rmap_wave_turn(enum rmap_turn turn, uint64_t seed, struct rmap_wave_pack *pack);

/* How rays [first, end) set out, at most RMAP_WAVE_AHEAD. */
void rmap_wave_depart(const struct rmap_retrace *r, size_t first, size_t end,
                      struct rmap_departure *departure);

#endif
