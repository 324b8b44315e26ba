/* SPDX-License-Identifier: MIT
 *
 * Pictures of a camera that become better while one looks.
 */
#ifndef RMAP_SERVE_RENDER_H
#define RMAP_SERVE_RENDER_H

#include "mpi/serve/serve_state.h"

/* Collective; a request, {"camera", "samples", "size", ...}: pictures of 1, 4, 16, ... samples a
 * pixel are told on the way, each in its turn among other requests; the last is the answer. */
enum rmap_status rmap_serve_render(struct rmap_serve *self, const json_t *message, json_t **result,
                                   struct rmap_error *err) RMAP_MUST_USE;

#endif
