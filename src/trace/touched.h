/* SPDX-License-Identifier: MIT
 *
 * Which recorded rays of a scene are other ones in a later version of it.
 */
#ifndef RMAP_TOUCHED_H
#define RMAP_TOUCHED_H

#include "accel/accel_places.h"
#include "portion/portion.h"
#include "scene/scene_change.h"
#include "trace/tracer.h"

/* Immutable once it is made; any number of threads. Zeroed: empty. */
struct rmap_touch {
    struct rmap_scene_change change;
    struct rmap_places places; /* of what moved, came or went, and of detectors */
    double loose; /* how far before its start a ray of a file may be put on a surface */
};

/* The scenes are borrowed for the call. RMAP_SYSTEM. */
enum rmap_status rmap_touch_init(struct rmap_touch *touch, const struct rmap_scene *old,
                                 const struct rmap_scene *new,
                                 struct rmap_error *err) RMAP_MUST_USE;
void rmap_touch_fini(struct rmap_touch *touch);

/* touched: [rays of the portion], which is of the old scene; 1: the ray must be traced in the new
 * one, as its path tells. */
#define RMAP_TOUCH_PATH_COLUMNS (RMAP_COLUMNS_DISCRETE | RMAP_COLUMN_BIT(RMAP_RAY_start_object))
void rmap_touch_paths(const struct rmap_touch *touch, const struct rmap_portion *portion,
                      uint8_t *touched);

/* Besides, as its place tells, where the path did not. Returns how many there are of both. */
#define RMAP_TOUCH_PLACE_COLUMNS                                                                   \
    (RMAP_COLUMN_BIT(RMAP_RAY_start) | RMAP_COLUMN_BIT(RMAP_SEGMENT_position))
size_t rmap_touch_places(const struct rmap_touch *touch, const struct rmap_portion *portion,
                         uint8_t *touched);

/* What a touched ray, whose rows begin there, meets before its path is another; borrowed. */
struct rmap_known_way rmap_touch_known(const struct rmap_touch *touch,
                                       const struct rmap_portion *portion,
                                       const size_t first[RMAP_TABLE_COUNT]);

/* Rows of the other rays become those of the new scene: [first_ray, ...) and on of each table. */
void rmap_touch_renumber(const struct rmap_touch *touch, struct rmap_portion *portion,
                         const size_t first[RMAP_TABLE_COUNT]);

#endif
