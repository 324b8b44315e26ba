/* SPDX-License-Identifier: MIT
 *
 * What the command line of `raymap trace` asks for.
 */
#ifndef RMAP_TRACE_REQUEST_H
#define RMAP_TRACE_REQUEST_H

#include "compact/layout.h"
#include "mpi/command/load.h"

extern const struct rmap_option rmap_trace_options[];

enum rmap_trace_mode { RMAP_TRACE_NEW, RMAP_TRACE_RESUME, RMAP_TRACE_APPEND };

struct rmap_trace_request {
    const char *scene_path, *map_path; /* map_path NULL: nothing is recorded */
    const char *from_path;             /* map of another version of the scene; NULL: none */
    enum rmap_trace_mode mode;
    uint64_t n_ray; /* 0: not given, until rmap_trace_request_complete */
    uint64_t first_ray;
    uint64_t n_of_parent; /* rays of the map at from_path; 0: none, or -n says */
    uint64_t n_photon;    /* of the scene, each a ray; 0: not counted */
    bool has_n_ray, has_first_ray, has_seed, force;
    uint64_t seed, piece_nbytes;
    double time_limit_s;
    enum rmap_encoding encoding; /* if not given, the map's own, or compact */
    bool has_encoding;
    double flush_s;           /* 0: the writer's default */
    uint64_t flush_portions;  /* 0: by time alone */
    const char *shard_dir;    /* NULL: in the map */
    uint64_t shards_per_node; /* 0: one per rank */
    struct rmap_scene_options scene;
};

/* RMAP_USAGE for what cannot be, with the remedy. The caller, or rmap_load_scene, releases
 * request->scene. */
enum rmap_status rmap_trace_request_read(const struct rmap_arguments *given,
                                         struct rmap_trace_request *request,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* RMAP_USAGE for more rays than there can be. */
enum rmap_status rmap_trace_request_fits(const struct rmap_trace_request *request, uint64_t first,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* What the command line leaves open, the chosen simulation of the scene says. */
enum rmap_status rmap_trace_request_complete(const struct rmap_arguments *given,
                                             const struct rmap_scene *scene,
                                             struct rmap_trace_request *request,
                                             struct rmap_error *err) RMAP_MUST_USE;

#endif
