/* SPDX-License-Identifier: MIT
 *
 * What the command line of `raymap trace` asks for.
 */
#include "mpi/trace/trace_request.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "mpi/command/argument_numbers.h"
#include "portion/ray_plan.h"

const struct rmap_option rmap_trace_options[] = {
    {"output", 'o', "MAP", "directory of the ray map to make, by custom NAME.raymap"},
    {"rays", 'n', "RAYS", "how many: 1000000, 1e6, 2M (default: the simulation's, or 1e6)"},
    {"first-ray", 0, "ID", "id of the first ray (default 0): a part of what one map may hold"},
    {"seed", 's', "S", "of the random numbers (default 1): the same seed gives the same rays"},
    {"time-limit", 't', "TIME",
     "stop in good order after 90s, 3h50min, 1:30:00, 1-00:00:00: status 6"},
    {"force", 'f', NULL, "replace a ray map that stands there", "output"},
    {"time", 0, "MODE",
     "on: with times of arrival, by group index (default: the simulation's, or off)",
     .words = "on off"},
    {"no-record", 0, NULL, "trace and sum up only; makes no map"},
    {"resume", 0, NULL, "trace what a map still lacks; begin it where there is none"},
    {"index", 0, NULL, "accepted, without effect: maps need no index"},
    {"from", 0, "MAP",
     "keep what rays of this map, of an earlier version of the scene, the change leaves as they "
     "are"},
    {"append", 0, NULL, "add -n more rays to a map; what it still lacks comes first"},
    {"encoding", 0, "NAME",
     "plain or compact: how the map is stored (default compact; plain has columns for h5py)",
     .words = "plain compact"},
    {"piece-size", 0, "BYTES",
     "close a file of the map that has so much to compress (default 512Mi)"},
    {"flush", 0, "TIME", "what was traced longer ago is safe from any crash (default 10s)"},
    {"flush-portions", 0, "N", "the same after every N blocks of 4096 rays of a shard"},
    {"shard-dir", 0, "DIR", "write the map's files below DIR, as a node's own disk"},
    {"shards-per-node", 0, "N", "writers per node, shared by its ranks (default: every rank)"},
    RMAP_SCENE_OPTIONS,
    {NULL}};

static enum rmap_status check_modes(const struct rmap_arguments *given,
                                    const struct rmap_trace_request *request,
                                    struct rmap_error *err)
{
    bool resume = rmap_argument(given, "resume"), append = rmap_argument(given, "append");
    const char *going_on = append ? "--append" : "--resume";
    if (resume && append)
        return rmap_error_set(err, RMAP_USAGE,
                              "--append completes a map before it adds to it; leave out --resume");
    if (request->from_path && append)
        return rmap_error_set(err, RMAP_USAGE,
                              "--from makes a map of its own, and --append adds to one: leave out "
                              "one of them");
    if (request->from_path && rmap_argument(given, "no-record"))
        return rmap_error_set(err, RMAP_USAGE, "--from makes a map; leave out --no-record");
    if (!resume && !append)
        return RMAP_OK;
    if (request->force)
        return rmap_error_set(err, RMAP_USAGE, "--force removes the map that %s goes on with",
                              going_on);
    if (rmap_argument(given, "no-record"))
        return rmap_error_set(err, RMAP_USAGE, "%s needs the map; leave out --no-record", going_on);
    if (!request->map_path)
        return rmap_error_set(err, RMAP_USAGE, "which map? %s needs -o MAP", going_on);
    if (append && !request->has_n_ray)
        return rmap_error_set(err, RMAP_USAGE, "--append needs -n: how many rays more");
    return RMAP_OK;
}

static enum rmap_status check_request(const struct rmap_arguments *given,
                                      const struct rmap_trace_request *request,
                                      struct rmap_error *err)
{
    static const char *const for_maps[] = {"encoding",       "piece-size", "flush",
                                           "flush-portions", "shard-dir",  "shards-per-node",
                                           "index"};
    enum rmap_status st = check_modes(given, request, err);
    if (st != RMAP_OK)
        return st;
    if (request->has_n_ray && request->n_ray == 0)
        return rmap_error_set(err, RMAP_USAGE, "-n 0 traces nothing; ask for at least one ray");
    if (rmap_argument(given, "no-record") && request->map_path)
        return rmap_error_set(err, RMAP_USAGE, "--no-record makes no map; leave out -o");
    for (size_t i = 0; i < sizeof for_maps / sizeof *for_maps; i++)
        if (rmap_argument(given, "no-record") && rmap_argument(given, for_maps[i]))
            return rmap_error_set(err, RMAP_USAGE, "--no-record makes no map; leave out --%s",
                                  for_maps[i]);
    if (rmap_argument(given, "piece-size") && request->piece_nbytes == 0)
        return rmap_error_set(err, RMAP_USAGE, "--piece-size must be at least 1");
    if (rmap_argument(given, "flush-portions") && request->flush_portions == 0)
        return rmap_error_set(err, RMAP_USAGE, "--flush-portions must be at least 1");
    if (rmap_argument(given, "shards-per-node") && request->shards_per_node == 0)
        return rmap_error_set(err, RMAP_USAGE, "--shards-per-node must be at least 1");
    return RMAP_OK;
}

static enum rmap_status read_encoding(const struct rmap_arguments *given,
                                      struct rmap_trace_request *request, struct rmap_error *err)
{
    const char *text = rmap_argument(given, "encoding");
    if (!text)
        return RMAP_OK;
    for (int e = 0; e < RMAP_ENCODING_COUNT; e++) {
        if (strcmp(text, rmap_encoding_name((enum rmap_encoding)e)) != 0)
            continue;
        if (!rmap_layout_of((enum rmap_encoding)e, RMAP_COLOUR_SPECTRAL))
            return rmap_error_set(
                err, RMAP_USAGE, "--encoding %s is not available in this version; use plain", text);
        request->encoding = (enum rmap_encoding)e;
        request->has_encoding = true;
        return RMAP_OK;
    }
    return rmap_error_set(err, RMAP_USAGE, "--encoding is 'plain' or 'compact', not '%s'", text);
}

/* --time, as --set would say it: so a map keeps it. */
static enum rmap_status set_time(const struct rmap_arguments *given,
                                 struct rmap_scene_options *options, struct rmap_error *err)
{
    const char *time = rmap_argument(given, "time");
    const char *simulation = options->simulation;
    if (!time)
        return RMAP_OK;
    if (strcmp(time, "on") != 0 && strcmp(time, "off") != 0)
        return rmap_error_set(err, RMAP_USAGE, "--time is 'on' or 'off', not '%s'", time);
    const size_t nbytes = (simulation ? strlen(simulation) : 0) + sizeof "simulations..time=off";
    char **set = rmap_realloc(options->set, options->n_set + 1, sizeof *set);
    if (set)
        options->set = set;
    char *text = set ? rmap_alloc(nbytes, 1) : NULL;
    if (!text)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the command line");
    (void)snprintf(text, nbytes, "%s%s%stime=%s", simulation ? "simulations." : "",
                   simulation ? simulation : "", simulation ? "." : "", time);
    set[options->n_set++] = text;
    return RMAP_OK;
}

enum rmap_status rmap_trace_request_read(const struct rmap_arguments *given,
                                         struct rmap_trace_request *request, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    *request = (struct rmap_trace_request){
        .scene_path = given->operand[0], .seed = 1, .encoding = RMAP_ENCODING_COMPACT};
    request->map_path = rmap_argument(given, "output");
    request->from_path = rmap_argument(given, "from");
    request->shard_dir = rmap_argument(given, "shard-dir");
    request->force = rmap_argument(given, "force") != NULL;
    request->has_n_ray = rmap_argument(given, "rays") != NULL;
    request->has_first_ray = rmap_argument(given, "first-ray") != NULL;
    request->has_seed = rmap_argument(given, "seed") != NULL;
    request->mode = rmap_argument(given, "append")   ? RMAP_TRACE_APPEND
                    : rmap_argument(given, "resume") ? RMAP_TRACE_RESUME
                                                     : RMAP_TRACE_NEW;
    RMAP_TRY(rmap_argument_count(given, "rays", &request->n_ray, err));
    RMAP_TRY(rmap_argument_count(given, "first-ray", &request->first_ray, err));
    RMAP_TRY(rmap_argument_count(given, "seed", &request->seed, err));
    RMAP_TRY(rmap_argument_count(given, "piece-size", &request->piece_nbytes, err));
    RMAP_TRY(rmap_argument_count(given, "flush-portions", &request->flush_portions, err));
    RMAP_TRY(rmap_argument_count(given, "shards-per-node", &request->shards_per_node, err));
    RMAP_TRY(rmap_argument_seconds(given, "time-limit", &request->time_limit_s, err));
    RMAP_TRY(rmap_argument_seconds(given, "flush", &request->flush_s, err));
    RMAP_TRY(read_encoding(given, request, err));
    RMAP_TRY(check_request(given, request, err));
    RMAP_TRY(rmap_scene_options_read(given, &request->scene, err));
    RMAP_TRY(set_time(given, &request->scene, err));
out:
    return st;
}

enum rmap_status rmap_trace_request_fits(const struct rmap_trace_request *request, uint64_t first,
                                         struct rmap_error *err)
{
    const uint64_t end = request->n_photon ? request->n_photon : RMAP_RAY_END;
    if (first <= end && request->n_ray <= end - first)
        return RMAP_OK;
    return request->n_photon
               ? rmap_error_set(err, RMAP_USAGE,
                                "the scene has %llu photons, each of which is a ray ('count: "
                                "counted'): %llu rays from %llu on are too many",
                                (unsigned long long)end, (unsigned long long)request->n_ray,
                                (unsigned long long)first)
               : rmap_error_set(err, RMAP_USAGE,
                                "%llu rays from %llu on are too many: ids end at 2^64 - 2",
                                (unsigned long long)request->n_ray, (unsigned long long)first);
}

enum rmap_status rmap_trace_request_complete(const struct rmap_arguments *given,
                                             const struct rmap_scene *scene,
                                             struct rmap_trace_request *request,
                                             struct rmap_error *err)
{
    const uint64_t default_rays = 1000000;
    const struct rmap_simulation *simulation = &scene->simulation;
    bool record = !rmap_argument(given, "no-record") &&
                  (request->mode != RMAP_TRACE_NEW || simulation->record || !simulation->name);
    request->n_photon = rmap_scene_n_photon(scene);
    if (!request->has_n_ray)
        request->n_ray = request->n_of_parent ? request->n_of_parent
                         : simulation->rays   ? simulation->rays
                         : request->n_photon  ? request->n_photon
                                              : default_rays;
    if (request->time_limit_s <= 0.0)
        request->time_limit_s = simulation->time_limit_s;
    if (request->mode == RMAP_TRACE_NEW) {
        const enum rmap_status st = rmap_trace_request_fits(request, request->first_ray, err);
        if (st != RMAP_OK)
            return st;
    }
    if (scene->n_source == 0)
        return rmap_error_set(err, RMAP_INPUT, "%s: no source takes part, so there is no light",
                              request->scene_path);
    if (record && !request->map_path)
        return rmap_error_set(err, RMAP_USAGE,
                              "where to? give -o MAP, or --no-record to trace without a map");
    if (!record)
        request->map_path = NULL;
    return RMAP_OK;
}
