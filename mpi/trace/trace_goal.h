/* SPDX-License-Identifier: MIT
 *
 * What a trace is to do: begin a map, complete one, or add to one. The same on every rank.
 */
#ifndef RMAP_TRACE_GOAL_H
#define RMAP_TRACE_GOAL_H

#include "io/map/map_writer.h"
#include "mpi/trace/trace_request.h"
#include "portion/ray_plan.h"

/* Rays still to be traced of one request. */
struct rmap_trace_phase {
    int32_t space;
    struct rmap_ray_set rays;
};

struct rmap_trace_goal {
    struct rmap_map *map;    /* that is gone on with; NULL: a new one, or none */
    int32_t space;           /* of the command line's scene in the map */
    struct rmap_run_row row; /* asked for now */
    bool has_row;            /* to be added to the map's runs */
    struct rmap_trace_phase *phase;
    size_t n_phase;
    uint64_t n_missing; /* rays of all phases */
    uint64_t n_held;    /* rays that count as traced: in sealed pieces of the map */
    size_t *recount;    /* [n_recount] portions whose sums the map's index has not */
    size_t n_recount;
};

/* A map that does not stand yet, or none. */
enum rmap_status rmap_trace_goal_begin(const struct rmap_trace_request *request,
                                       struct rmap_trace_goal *goal,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* A map that stands: goal->map, opened without sums over what stands beside its index. Whether the
 * trace may go on with it. RMAP_INPUT: another scene, seed or instruction set; RMAP_USAGE: numbers
 * that do not fit the map. request->seed and ->encoding become the map's where the command line
 * gave none; run->seed and ->encoding with them. */
enum rmap_status rmap_trace_goal_admit(struct rmap_trace_request *request, struct rmap_run *run,
                                       struct rmap_trace_goal *goal,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Then: what it lacks. */
enum rmap_status rmap_trace_goal_plan(struct rmap_trace_goal *goal,
                                      struct rmap_error *err) RMAP_MUST_USE;

void rmap_trace_goal_fini(struct rmap_trace_goal *goal); /* closes the map */

/* Nothing to trace, nothing to sum up, and the index says so. */
bool rmap_trace_goal_is_idle(const struct rmap_trace_goal *goal);

#endif
