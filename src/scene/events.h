/* SPDX-License-Identifier: MIT
 *
 * Events: what happened once, such as the passage of a particle, and made light. Files of rays and
 * of steps number them, so that the event of a ray follows from its id.
 */
#ifndef RMAP_EVENTS_H
#define RMAP_EVENTS_H

#include "scene/scene.h"

/* Some source has a file that numbers events. */
bool rmap_scene_has_events(const struct rmap_scene *scene);

/* Why events cannot be asked for; NULL: they can. */
const char *rmap_scene_events_trouble(const struct rmap_scene *scene);

/* The event that a ray is of. False: its source has none. The scene is that of the ray's colour
 * space, with the seed of its map. */
bool rmap_scene_event(const struct rmap_scene *scene, uint64_t ray, uint64_t *event_ret);

/* Numbers of all events of all sources, each once, ascending: [*n_ret], rmap_free. RMAP_SYSTEM. */
enum rmap_status rmap_scene_events(const struct rmap_scene *scene, uint64_t **event_ret,
                                   size_t *n_ret, struct rmap_error *err) RMAP_MUST_USE;

/* Where an event stands in such a list that has it. */
size_t rmap_event_index(const uint64_t *event, size_t n, uint64_t of);

/* Ids of rays outside of [first_ret, last_ret] are of none of the events [low, high]: where photons
 * are counted they come event by event. */
void rmap_scene_rays_of_events(const struct rmap_scene *scene, uint64_t low, uint64_t high,
                               uint64_t *first_ret, uint64_t *last_ret);

#endif
