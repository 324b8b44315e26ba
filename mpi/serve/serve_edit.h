/* SPDX-License-Identifier: MIT
 *
 * What the request of an edit makes of a scene's text.
 */
#ifndef RMAP_SERVE_EDIT_H
#define RMAP_SERVE_EDIT_H

#include "mpi/serve/serve_state.h"

/* *base_ret: the number of the text that is changed; *lying_ret: the detector that is moved, if it
 * is one that lies on something. */
enum rmap_status rmap_serve_edited(const struct rmap_serve *self, const json_t *message,
                                   size_t *base_ret, struct rmap_serve_lying *lying_ret,
                                   struct rmap_scene_text *text_ret,
                                   struct rmap_error *err) RMAP_MUST_USE;

#endif
