/* SPDX-License-Identifier: MIT
 *
 * Pictures of a camera that become better while one looks.
 */
#ifndef RMAP_SERVE_RENDER_H
#define RMAP_SERVE_RENDER_H

#include "mpi/serve/serve_state.h"

/* Collective; a request, {"camera", "samples", "size", ...}: pictures of 1, 4, 16, ... samples a
 * pixel are told on the way; the last is the answer. It is of the scene as it was at first. */
enum rmap_status rmap_serve_render(struct rmap_serve *self, const json_t *message, json_t **result,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* Of pictures that are not done. */
void rmap_serve_render_fini(struct rmap_serve *self);

#endif
