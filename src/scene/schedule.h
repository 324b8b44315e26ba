/* SPDX-License-Identifier: MIT
 *
 * Which ray id belongs to which source: a fixed period in proportion to `rays_share`, whatever
 * the number of rays wanted, so that a map can grow without its rays changing.
 */
#ifndef RMAP_SCHEDULE_H
#define RMAP_SCHEDULE_H

#include "scene/scene.h"

/* Fills schedule, schedule_rank, schedule_len and schedule_quota of the scene, once. A scene
 * without sources gets a schedule of length 0. RMAP_INPUT for a share that is not a positive
 * number, RMAP_SYSTEM when memory is short. */
enum rmap_status rmap_scene_schedule(struct rmap_scene *scene,
                                     struct rmap_error *err) RMAP_MUST_USE;

#endif
