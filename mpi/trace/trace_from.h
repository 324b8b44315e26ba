/* SPDX-License-Identifier: MIT
 *
 * `raymap trace --from`: an older map, of another version of the scene, whose rays are taken over
 * as far as the change leaves them as they are.
 */
#ifndef RMAP_TRACE_FROM_H
#define RMAP_TRACE_FROM_H

#include "mpi/trace/trace_request.h"
#include "mpi/trace/trace_reuse.h"

struct rmap_trace_from {
    struct rmap_map *map; /* NULL: there is none */
    struct rmap_map_summary summary;
    char digest[33];
    struct rmap_reuse reuse;
    bool in_use;      /* rays are taken over */
    char all[256];    /* else why all are traced anew; "": not known yet */
    uint64_t n_other; /* rays of it in other colour spaces than those taken over */
};

/* Collective. Opens the map that the request names, if it names one; seed, rays and encoding that
 * the command line leaves open become the map's. RMAP_USAGE, RMAP_INPUT: no ray of it can be had in
 * the new map. */
enum rmap_status rmap_trace_from_open(const struct rmap_context *context,
                                      struct rmap_trace_request *request,
                                      struct rmap_trace_from *from,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* Collective. Which rays of it are rays of the scene, too; above a share of one half that are not,
 * none is taken over. Says on stderr if so, and why. isa, seed: of the new rays. */
enum rmap_status rmap_trace_from_decide(const struct rmap_context *context,
                                        struct rmap_trace_from *from,
                                        const struct rmap_scene *scene, const char *isa,
                                        uint64_t seed, struct rmap_error *err) RMAP_MUST_USE;

void rmap_trace_from_fini(struct rmap_trace_from *from); /* zeroed: fine */

#endif
