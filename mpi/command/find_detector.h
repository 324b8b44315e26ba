/* SPDX-License-Identifier: MIT
 *
 * The detector that a command line names, and its cells.
 */
#ifndef RMAP_FIND_DETECTOR_H
#define RMAP_FIND_DETECTOR_H

#include "scene/scene.h"

/* RMAP_INPUT, with the nearest name, when the scene has none of that name. */
enum rmap_status rmap_find_detector(const struct rmap_scene *scene, const char *name,
                                    int32_t *detector_ret, struct rmap_error *err) RMAP_MUST_USE;

/* "400x300" or "500" of --cells. RMAP_USAGE for what is none, or too many. or_else: what the caller
 * takes besides, for the message: ", or auto"; "". */
enum rmap_status rmap_read_cells(const char *text, const char *or_else, uint32_t cells[2],
                                 struct rmap_error *err) RMAP_MUST_USE;

#endif
