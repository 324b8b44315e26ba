/* SPDX-License-Identifier: MIT
 *
 * The rays of a scene traced into memory, by all ranks of a group.
 */
#ifndef RMAP_TRACE_HELD_H
#define RMAP_TRACE_HELD_H

#include "accel/accel.h"
#include "io/map/map_held.h"
#include "mpi/parallel/context.h"
#include "mpi/trace/trace_reuse.h"

/* What the rays of a rank may take; more is refused. */
#define RMAP_HELD_NBYTES_MAX ((size_t)2 << 30)

struct rmap_trace_held {
    uint64_t seed, n_ray;
    int isa_level;               /* Embree's */
    struct rmap_scene *scene;    /* taken over, and NULL then */
    const struct rmap_map *from; /* of another version of the scene, whose rays are taken over
                                    (trace_reuse.h): traced with the same seed, by the same group of
                                    ranks, with the same instruction set; borrowed. NULL: none */
    struct rmap_accel **accel; /* of another version of the scene or NULL, becomes the scene's, with
                                  the meshes of before that are the same. NULL: none is kept */
    double seconds;            /* grows by the time that tracing took, */
    uint64_t n_reused;         /* and by this rank's rays that were taken over */
};

/* Collective. Rays [0, n_ray), without a digest. RMAP_USAGE where they take too much memory. */
enum rmap_status rmap_trace_held(const struct rmap_context *context, struct rmap_trace_held *trace,
                                 struct rmap_map **map_ret, struct rmap_error *err) RMAP_MUST_USE;

/* Collective. The same, with a digest, of a map that has whole blocks of its first rays: it grows
 * to rays [0, end), of which those in `reuse` are taken over. seconds_ret, reused_ret: grow, as
 * above. On failure it is as it was, but where memory is short. */
enum rmap_status rmap_trace_held_more(const struct rmap_context *context,
                                      const struct rmap_accel *accel,
                                      const struct rmap_reuse *reuse, uint64_t end,
                                      struct rmap_map *map, double *seconds_ret,
                                      uint64_t *reused_ret, struct rmap_error *err) RMAP_MUST_USE;

#endif
