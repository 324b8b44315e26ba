/* SPDX-License-Identifier: MIT
 *
 * `raymap draw --time`: pictures of the light under way, step by step.
 */
#ifndef RMAP_DRAW_FILM_H
#define RMAP_DRAW_FILM_H

#include "analysis/figure/figure_draw.h"
#include "mpi/answer/draw_request.h"

/* request->n_frame pictures, in numbered files or one animated. given: but for the window. rays:
 * all columns. */
enum rmap_status rmap_draw_film(const struct rmap_draw_request *request,
                                const struct rmap_scene *scene, const struct rmap_portion *rays,
                                const struct rmap_figure_draw *given,
                                struct rmap_error *err) RMAP_MUST_USE;

#endif
