/* SPDX-License-Identifier: MIT
 *
 * Pictures of one size one after the other, as animated PNG (PNG, third edition, W3C 2025: chunks
 * acTL, fcTL, fdAT), which browsers play and other programs show the first picture of.
 */
#ifndef RMAP_ANIMATION_H
#define RMAP_ANIMATION_H

#include "io/export/svg.h"

struct rmap_animation;

/* In place of what stood at `path`, which must outlive it. RMAP_SYSTEM. */
enum rmap_status rmap_animation_create(const char *path, uint32_t n_frame, uint16_t per_second,
                                       struct rmap_animation **animation_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* The next of the n_frame pictures, which it finishes, at `scale` pixels per SVG pixel. */
enum rmap_status rmap_animation_add(struct rmap_animation *animation, struct rmap_svg *svg,
                                    double scale, struct rmap_error *err) RMAP_MUST_USE;

/* After the last one: the file has its name. */
enum rmap_status rmap_animation_finish(struct rmap_animation *animation,
                                       struct rmap_error *err) RMAP_MUST_USE;
void rmap_animation_destroy(struct rmap_animation *animation); /* NULL is fine */

#endif
