/* SPDX-License-Identifier: MIT
 *
 * Words that a session's line may be made of, for completion: the language's, and the names of the
 * map's scene.
 */
#ifndef RMAP_SESSION_WORDS_H
#define RMAP_SESSION_WORDS_H

#include <jansson.h>
#include <stdio.h>

#include "base/status.h"
#include "scene/scene.h"

/* *word_ret: [*n_ret] texts that the scene and the program own; rmap_free the list alone. */
enum rmap_status rmap_session_words(const struct rmap_scene *scene, const char ***word_ret,
                                    size_t *n_ret, struct rmap_error *err) RMAP_MUST_USE;

/* A line for each kind of name: "objects:  barrel  lens.1 ..." */
void rmap_session_names_print(const struct rmap_scene *scene, FILE *out);

/* The names of a kind, "detectors", a line each; none of a kind that there is not. */
void rmap_session_names_list(const struct rmap_scene *scene, const char *kind, FILE *out);

/* {"objects": [...], ...}, a list for each kind. The caller's; NULL when memory is short. */
json_t *rmap_session_names_json(const struct rmap_scene *scene);

#endif
