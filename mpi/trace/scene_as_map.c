/* SPDX-License-Identifier: MIT
 *
 * Commands that ask maps can be given a scene: its first rays are traced into memory for them.
 */
#include "mpi/trace/scene_as_map.h"

#include "analysis/query/map_light.h"
#include "mpi/command/argument_numbers.h"
#include "mpi/command/load.h"
#include "mpi/command/output.h"
#include "mpi/parallel/agree.h"
#include "mpi/trace/trace_held.h"

static enum rmap_status trace(const struct rmap_context *context, const char *path, uint64_t n_ray,
                              struct rmap_map **map_ret, struct rmap_error *err)
{
    struct rmap_scene_options options = {.read_map = rmap_map_light_read};
    struct rmap_bundle *bundle = NULL;
    struct rmap_trace_held held = {.seed = 1};
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(rmap_load_scene(context, path, &options, &bundle, &held.scene, err));
    RMAP_TRY(rmap_common_isa(context, &held.isa_level, err));
    held.n_ray = held.scene->n_source > 0 ? n_ray : 0;
    RMAP_TRY(rmap_trace_held(context, &held, map_ret, err));
out:
    rmap_scene_destroy(held.scene);
    rmap_bundle_destroy(bundle);
    return st;
}

enum rmap_status rmap_load_map_or_scene(const struct rmap_context *context,
                                        const struct rmap_arguments *given, const char *path,
                                        uint64_t n_ray, struct rmap_map **map_ret,
                                        struct rmap_error *err)
{
    const bool has_n = rmap_argument(given, "rays") != NULL;
    const bool is_scene =
        !context->at_hand && (rmap_output_is(path, ".yaml") || rmap_output_is(path, ".yml"));
    enum rmap_status st = rmap_argument_count(given, "rays", &n_ray, err);
    if (st == RMAP_OK && has_n && !is_scene)
        st = rmap_error_set(err, RMAP_USAGE, "-n is for a scene (.yaml): a map has its rays");
    RMAP_TRY(rmap_agree(context, st, err));
    st = is_scene ? trace(context, path, n_ray, map_ret, err)
                  : rmap_load_map(context, path, map_ret, err);
out:
    return st;
}
