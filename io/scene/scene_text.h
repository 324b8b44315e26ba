/* SPDX-License-Identifier: MIT
 *
 * Changes of a scene's text that leave the rest of it, comments and order, as it is written.
 */
#ifndef RMAP_SCENE_TEXT_H
#define RMAP_SCENE_TEXT_H

#include <jansson.h>

#include "base/status.h"

/* The text without some keys or items of lists (["objects.lens", ...]; NULL: none), and then with
 * other values: {"objects.lens.at": [0, 0, 5], ...}. Key paths are those of --set. Keys that are
 * missing are added, as is to a list an item, a mapping, of a name that it has not. What an alias
 * stands for is changed where it is written, and taken away where the alias stands. *text_ret:
 * rmap_free. RMAP_INPUT: the text is no YAML, or a path leads nowhere. */
enum rmap_status rmap_scene_text_change(const char *text, const json_t *remove,
                                        const json_t *values, char **text_ret,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* The text with an object, group, source or detector `by` so much ([x, y, z], in the units of the
 * scene and the frame of its `at`) elsewhere. */
enum rmap_status rmap_scene_text_move(const char *text, const char *name, const json_t *by,
                                      char **text_ret, struct rmap_error *err) RMAP_MUST_USE;

#endif
