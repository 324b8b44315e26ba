/* SPDX-License-Identifier: MIT
 *
 * The rays of a scene traced into memory, by all ranks of a group.
 */
#ifndef RMAP_TRACE_HELD_H
#define RMAP_TRACE_HELD_H

#include "io/map/map_held.h"
#include "mpi/parallel/context.h"

/* What the rays of a rank may take; more is refused. */
#define RMAP_HELD_NBYTES_MAX ((size_t)2 << 30)

/* Collective. Rays [0, n_ray), with Embree's instruction set of that level. The scene is taken over
 * on success. RMAP_USAGE where they take too much memory. seconds_ret: grows by the time that
 * tracing took. */
enum rmap_status rmap_trace_held(const struct rmap_context *context, struct rmap_scene *scene,
                                 uint64_t seed, uint64_t n_ray, int isa_level,
                                 struct rmap_map **map_ret, double *seconds_ret,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* The same; rays that `from`, of another version of the scene, has already are taken over from it
 * (trace_reuse.h). It holds the same rays, of the same seed, and was traced by the same group of
 * ranks with the same instruction set; borrowed. NULL: all are traced. reused_ret: grows by this
 * rank's rays that were taken over. */
enum rmap_status rmap_trace_held_from(const struct rmap_context *context,
                                      const struct rmap_map *from, struct rmap_scene *scene,
                                      uint64_t seed, uint64_t n_ray, int isa_level,
                                      struct rmap_map **map_ret, double *seconds_ret,
                                      uint64_t *reused_ret, struct rmap_error *err) RMAP_MUST_USE;

#endif
