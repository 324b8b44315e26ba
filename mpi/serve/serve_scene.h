/* SPDX-License-Identifier: MIT
 *
 * The scene of a server: read, edited as text, undone and saved.
 */
#ifndef RMAP_SERVE_SCENE_H
#define RMAP_SERVE_SCENE_H

#include "mpi/serve/serve_state.h"

/* Whether a file of that name is a scene; others are maps. */
bool rmap_serve_is_scene_name(const char *path);

/* Collective. A scene's file, or a map, in the place of what was open; on failure that stays. */
enum rmap_status rmap_serve_open(struct rmap_serve *self, const char *path,
                                 struct rmap_error *err) RMAP_MUST_USE;
void rmap_serve_scene_fini(struct rmap_serve *self);

/* Nothing is taken over from what was before. */
void rmap_serve_forget_last(struct rmap_serve *self);

/* The file of the scene: that was opened, or that the scene of a map was saved to first. */
const char *rmap_serve_file(const struct rmap_serve *self);

/* Of a map that was opened: what its rays had that new ones have not; NULL: nothing. */
const char *rmap_serve_remark(const struct rmap_serve *self);

/* Collective. The scene of the text that is now, without rays. */
enum rmap_status rmap_serve_anew(struct rmap_serve *self, uint64_t seed,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* Collective; requests. A scene that is wrong is refused with self->details, and all is as it was.
 */
enum rmap_status rmap_serve_load(struct rmap_serve *self, const json_t *message, json_t **result,
                                 struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_serve_edit(struct rmap_serve *self, const json_t *message, json_t **result,
                                 struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_serve_undo(struct rmap_serve *self, const json_t *message, json_t **result,
                                 struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_serve_redo(struct rmap_serve *self, const json_t *message, json_t **result,
                                 struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_serve_save(struct rmap_serve *self, const json_t *message, json_t **result,
                                 struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_serve_scene(struct rmap_serve *self, const json_t *message, json_t **result,
                                  struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_serve_names(struct rmap_serve *self, const json_t *message, json_t **result,
                                  struct rmap_error *err) RMAP_MUST_USE;

#endif
