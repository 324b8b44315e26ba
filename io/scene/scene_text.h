/* SPDX-License-Identifier: MIT
 *
 * Changes of a scene's text that leave the rest of it, comments and order, as it is written.
 */
#ifndef RMAP_SCENE_TEXT_H
#define RMAP_SCENE_TEXT_H

#include <jansson.h>

#include "base/status.h"
#include "base/vec.h"
#include "io/scene/yaml_tree.h"

/* A text with its tree, which follows the changes of values that are plain or lists of such. */
struct rmap_scene_text {
    char *text;
    struct rmap_yaml_node *root; /* NULL: it has not been read */
    bool is_sound;               /* the tree is all that reading found: no mistakes */
    bool is_move;                /* from the text before it something moved, and nothing else */
};
void rmap_scene_text_fini(struct rmap_scene_text *scene);

/* Makes the tree, unless it is there. RMAP_INPUT: the text is no YAML. */
enum rmap_status rmap_scene_text_parse(struct rmap_scene_text *scene,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* The text without some keys or items of lists (["objects.lens", ...]; NULL: none), and then with
 * other values: {"objects.lens.at": [0, 0, 5], ...}. Key paths are those of --set. Keys that are
 * missing are added, as is to a list an item, a mapping, of a name that it has not. In the place of
 * an alias stands the value, a key that '<<' brings is written into the mapping itself: nothing
 * else changes, as of --set. `from` gets its tree, if it has none. RMAP_INPUT: the text is no YAML,
 * a path leads nowhere or into what stands elsewhere, or what others have by an anchor would
 * change. */
enum rmap_status rmap_scene_text_change(struct rmap_scene_text *from, const json_t *remove,
                                        const json_t *values, struct rmap_scene_text *scene_ret,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* The text with an object, group, source or detector `by` so much ([x, y, z], in the units of the
 * scene) elsewhere. frame: that of its `at`, when `by` is along the axes of the world; NULL: it is
 * along those of that frame. from_place: where a detector without `at` stands, by what it lies on;
 * NULL: at the origin, as all else. */
enum rmap_status rmap_scene_text_move(struct rmap_scene_text *from, const char *name,
                                      const json_t *by, const struct rmap_affine *frame,
                                      const struct rmap_vec3 *from_place,
                                      struct rmap_scene_text *scene_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* The text for another folder, from which the way ("../parts/") leads to the present one: with that
 * before the names of files that are relative, and before those of included files that do not go
 * with the scene (scene_include.h). *text_ret: rmap_free; NULL at first. */
enum rmap_status rmap_scene_text_lead(const char *text, const char *way, char **text_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
