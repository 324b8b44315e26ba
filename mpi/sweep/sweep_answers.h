/* SPDX-License-Identifier: MIT
 *
 * What a sweep asks of one variant's map, as query, detector and stats answer it.
 */
#ifndef RMAP_SWEEP_ANSWERS_H
#define RMAP_SWEEP_ANSWERS_H

#include "analysis/sweep/sweep_table.h"
#include "io/map/map_reader.h"
#include "mpi/parallel/context.h"

/* Whether criteria of the answers suit the scene, before anything is traced. RMAP_INPUT. */
enum rmap_status rmap_sweep_check(const struct rmap_sweep *sweep, const struct rmap_scene *scene,
                                  struct rmap_error *err) RMAP_MUST_USE;

/* Collective. result: [n_answer], and part: [n_answer][RMAP_SWEEP_PARTS], NaN where an answer has
 * none; complete on rank 0. RMAP_INPUT, RMAP_USAGE name the answer. */
enum rmap_status rmap_sweep_ask(const struct rmap_context *context, const struct rmap_sweep *sweep,
                                const struct rmap_map *map, struct rmap_sweep_result *result,
                                double *part, struct rmap_error *err) RMAP_MUST_USE;

#endif
