/* SPDX-License-Identifier: MIT
 *
 * A command's inputs, on every rank.
 */
#include "mpi/command/load.h"

#include <stdio.h>
#include <string.h>

#include "analysis/query/map_light.h"
#include "base/alloc.h"
#include "base/grouped.h"
#include "io/map/map_directory.h"
#include "io/map/map_rays.h"
#include "io/map/map_reader.h"
#include "io/map/map_state.h"
#include "io/map/map_writer.h"
#include "io/mesh/bundle_pack.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/at_hand.h"
#include "mpi/parallel/node.h"
#include "mpi/parallel/progress.h"

enum rmap_status rmap_scene_options_read(const struct rmap_arguments *given,
                                         struct rmap_scene_options *options, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    *options = (struct rmap_scene_options){.read_map = rmap_map_light_read};
    const char *simulation = rmap_argument(given, "simulation");
    const char *color = rmap_argument(given, "color");
    if (color && strcmp(color, "rgb") != 0 && strcmp(color, "spectral") != 0)
        return rmap_error_set(err, RMAP_USAGE, "--color is 'rgb' or 'spectral', not '%s'", color);
    options->simulation = rmap_strdup(simulation);
    options->color = rmap_strdup(color);
    if ((simulation && !options->simulation) || (color && !options->color))
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the command line");
    RMAP_TRY(st);
    options->allows_plugins = rmap_argument(given, "allow-plugins") != NULL;
    options->allowing = rmap_arguments_again(given, "allow-plugins");
    RMAP_TRY(rmap_argument_list(given, "only", &options->only, &options->n_only, err));
    RMAP_TRY(rmap_argument_list(given, "without", &options->without, &options->n_without, err));
    RMAP_TRY(rmap_argument_each(given, "set", &options->set, &options->n_set, err));
    for (size_t i = 0; i < options->n_set && st == RMAP_OK; i++)
        if (!strchr(options->set[i], '='))
            st =
                rmap_error_set(err, RMAP_USAGE, "--set wants KEY=VALUE, not '%s'", options->set[i]);
out:
    if (st != RMAP_OK)
        rmap_scene_options_fini(options);
    return st;
}

/* NULL: the path is that of a file. */
static const struct rmap_at_hand *at_hand_of(const struct rmap_context *context, const char *path)
{
    return context->at_hand && strcmp(path, context->at_hand->path) == 0 ? context->at_hand : NULL;
}

/* Of the scene at hand: its text as it is by now, with all else of its map, or with the files
 * beside it, of which those that are as they were are not read again. */
static enum rmap_status bundle_at_hand(const struct rmap_at_hand *at_hand,
                                       struct rmap_scene_options *options,
                                       struct rmap_bundle **bundle_ret, struct rmap_error *err)
{
    options->root = at_hand->root;
    options->before_scene = at_hand->map ? rmap_map_scene(at_hand->map) : NULL;
    if (at_hand->is_map)
        return rmap_bundle_share(at_hand->bundle, at_hand->text, options, bundle_ret, err);
    options->before = at_hand->bundle;
    return rmap_bundle_of_text(at_hand->path, at_hand->text, options, bundle_ret, err);
}

enum rmap_status rmap_load_bundle(const struct rmap_context *context, const char *path,
                                  struct rmap_scene_options *options,
                                  struct rmap_bundle **bundle_ret, struct rmap_error *err)
{
    rmap_free(options->cache);
    options->cache = rmap_strdup(context->cache); /* without memory there is none */
    if (at_hand_of(context, path))
        return bundle_at_hand(context->at_hand, options, bundle_ret, err);
    return rmap_bundle_open(path, options, bundle_ret, err);
}

/* Rank 0: the scene from its files. */
static enum rmap_status read_scene(const struct rmap_context *context, const char *path,
                                   struct rmap_scene_options *options,
                                   struct rmap_diagnostics *found, struct rmap_bundle **bundle,
                                   struct rmap_scene **scene, struct rmap_error *err)
{
    const enum rmap_status st = rmap_load_bundle(context, path, options, bundle, err);
    return st == RMAP_OK ? rmap_scene_read(*bundle, scene, found, err) : st;
}

/* Has it the same meshes as the scene at hand, one for one? They need not be sent. */
static bool has_meshes_at_hand(const struct rmap_bundle *bundle, const struct rmap_bundle *at_hand)
{
    bool same = at_hand && at_hand->n_mesh == bundle->n_mesh;
    for (size_t i = 0; same && i < bundle->n_mesh; i++)
        same = bundle->mesh[i].mesh == at_hand->mesh[i].mesh &&
               strcmp(bundle->mesh[i].geometry, at_hand->mesh[i].geometry) == 0;
    return same;
}

static enum rmap_status take_meshes_at_hand(struct rmap_bundle *bundle,
                                            const struct rmap_bundle *at_hand,
                                            struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < at_hand->n_mesh && st == RMAP_OK; i++) {
        st = rmap_bundle_add_mesh(bundle, at_hand->mesh[i].geometry, at_hand->mesh[i].mesh, err);
        if (st == RMAP_OK)
            (void)rmap_mesh_hold(at_hand->mesh[i].mesh);
    }
    return st;
}

/* Other ranks: the same scene from rank 0's bundle, without touching a file but plug-ins. at_hand:
 * NULL, or whose scene it is, edited. has_meshes: the bundle does not, but at_hand. */
static enum rmap_status rebuild_scene(const uint8_t *blob, size_t nbytes,
                                      const struct rmap_at_hand *at_hand, bool has_meshes,
                                      struct rmap_bundle **bundle, struct rmap_scene **scene,
                                      struct rmap_error *err)
{
    struct rmap_diagnostics diagnostics;
    rmap_diagnostics_init(&diagnostics, "scene");
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(rmap_bundle_unpack(blob, nbytes, bundle, err));
    if (has_meshes) {
        RMAP_TRY(take_meshes_at_hand(*bundle, at_hand->bundle, err));
        (*bundle)->options.root = at_hand->root;
        (*bundle)->options.before_scene = rmap_map_scene(at_hand->map);
    }
    if (!at_hand || !at_hand->is_map) {
        (*bundle)->loads_plugins = 1;             /* rank 0 had it from the scene file */
        (*bundle)->options.allows_plugins = true; /* and was allowed to load them */
    }
    RMAP_TRY(rmap_scene_read(*bundle, scene, &diagnostics, err));
out:
    rmap_diagnostics_fini(&diagnostics);
    return st;
}

enum rmap_status rmap_load_scene(const struct rmap_context *context, const char *path,
                                 struct rmap_scene_options *options,
                                 struct rmap_bundle **bundle_ret, struct rmap_scene **scene_ret,
                                 struct rmap_error *err)
{
    struct rmap_diagnostics found;
    rmap_diagnostics_init(&found, path);
    const enum rmap_status st =
        rmap_load_scene_told(context, path, options, &found, bundle_ret, scene_ret, err);
    if (context->rank == 0 && (st != RMAP_OK || !context->quiet))
        rmap_diagnostics_print(&found, stderr);
    rmap_diagnostics_fini(&found);
    return st;
}

enum rmap_status rmap_load_scene_told(const struct rmap_context *context, const char *path,
                                      struct rmap_scene_options *options,
                                      struct rmap_diagnostics *found,
                                      struct rmap_bundle **bundle_ret,
                                      struct rmap_scene **scene_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_bundle *bundle = NULL;
    struct rmap_scene *scene = NULL;
    uint8_t *blob = NULL;
    size_t nbytes = 0;
    bool has_meshes = false;
    const struct rmap_at_hand *at_hand = at_hand_of(context, path);
    if (context->rank == 0)
        st = read_scene(context, path, options, found, &bundle, &scene, err);
    if (st == RMAP_OK && context->rank == 0 && context->size > 1) {
        struct rmap_bundle sent = *bundle;
        has_meshes = at_hand && has_meshes_at_hand(bundle, at_hand->bundle);
        sent.n_mesh = has_meshes ? 0 : bundle->n_mesh;
        st = rmap_bundle_pack(&sent, &blob, &nbytes, err);
    }
    RMAP_TRY(rmap_agree(context, st, err));
    if (context->size > 1) {
        RMAP_TRY(RMAP_MPI(MPI_Bcast(&has_meshes, 1, MPI_C_BOOL, 0, context->comm)));
        RMAP_TRY(rmap_broadcast_blob(context, &blob, &nbytes, err));
        if (context->rank != 0)
            st = rebuild_scene(blob, nbytes, at_hand, has_meshes, &bundle, &scene, err);
        RMAP_TRY(rmap_agree(context, st, err));
    }
    *bundle_ret = bundle;
    *scene_ret = scene;
    bundle = NULL;
    scene = NULL;
out:
    rmap_free(blob);
    rmap_scene_destroy(scene);
    rmap_bundle_destroy(bundle);
    rmap_scene_options_fini(options);
    return st;
}

/* Collective. Whether all ranks opened the map in the same state: of one that is not complete the
 * others read the index alone. */
static enum rmap_status same_on_all(const struct rmap_context *context, const struct rmap_map *map,
                                    bool *same, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map_summary summary;
    rmap_map_summarise(map, &summary);
    uint64_t least[5] = {summary.digest.low, summary.digest.high, rmap_map_n_portion(map),
                         rmap_map_n_piece(map), summary.complete},
             most[5];
    memcpy(most, least, sizeof most);
    RMAP_TRY(RMAP_MPI(MPI_Allreduce(MPI_IN_PLACE, least, 5, MPI_UINT64_T, MPI_MIN, context->comm)));
    RMAP_TRY(RMAP_MPI(MPI_Allreduce(MPI_IN_PLACE, most, 5, MPI_UINT64_T, MPI_MAX, context->comm)));
    *same = memcmp(least, most, sizeof least) == 0;
out:
    return st;
}

/* Collective. What rank 0 has of a map becomes what all ranks have. */
static enum rmap_status send_state(const struct rmap_context *context, struct rmap_map *map,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint8_t *blob = NULL;
    size_t nbytes = 0;
    if (context->rank == 0)
        st = rmap_map_state_pack(map, &blob, &nbytes, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_broadcast_blob(context, &blob, &nbytes, err));
    if (context->rank != 0)
        st = rmap_map_state_take(map, blob, nbytes, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_free(blob);
    return st;
}

/* Collective. What the first rank of each node has becomes what its ranks have, all in the same
 * memory. */
static enum rmap_status share_in_node(const struct rmap_context *context,
                                      const struct rmap_node *node, struct rmap_map *map,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (node->is_first && node->memory >= 0)
        st = rmap_map_state_share(map, node->memory, err);
    RMAP_TRY(rmap_agree_patiently(context, st, err));
    if (node->memory >= 0)
        st = rmap_map_state_join(map, node->memory, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    return st;
}

enum rmap_status rmap_share_map(const struct rmap_context *context, struct rmap_map *map,
                                struct rmap_error *err)
{
    struct rmap_node node;
    if (context->size == 1)
        return RMAP_OK;
    enum rmap_status st = rmap_node_init(&node, context, err);
    RMAP_TRY(st);
    if (node.is_first)
        st = send_state(&node.firsts, map, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(share_in_node(context, &node, map, err));
out:
    rmap_node_fini(&node);
    return st;
}

/* An answer from part of the rays must not be taken for one from all: no wish for quiet silences
 * that. */
static void warn_incomplete(const struct rmap_context *context, const char *path,
                            const struct rmap_map *map)
{
    struct rmap_map_summary summary;
    char asked[RMAP_GROUPED_LEN];
    uint64_t n_asked = 0;
    if (context->rank != 0 || rmap_map_is_whole(map))
        return;
    rmap_map_summarise(map, &summary);
    const struct rmap_counted held = rmap_counted(summary.n_row[RMAP_TABLE_RAY], "ray");
    if (rmap_rays_asked(map, &n_asked))
        fprintf(stderr, "raymap: %s is not complete (see: raymap info): it holds %s of %s%s\n",
                path, held.text, rmap_grouped(n_asked, asked),
                n_asked == summary.n_row[RMAP_TABLE_RAY] ? ", and its trace has not ended" : "");
    else
        fprintf(stderr, "raymap: %s is not complete (see: raymap info): it holds %s\n", path,
                held.text);
}

enum rmap_status rmap_common_isa(const struct rmap_context *context, int *level_ret,
                                 struct rmap_error *err)
{
    *level_ret = rmap_accel_isa_level();
    return RMAP_MPI(MPI_Allreduce(MPI_IN_PLACE, level_ret, 1, MPI_INT, MPI_MIN, context->comm));
}

enum rmap_status rmap_load_accel(const struct rmap_context *context, const struct rmap_scene *scene,
                                 const char *isa, struct rmap_accel **accel_ret,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const int wanted = isa ? rmap_accel_isa_level_of(isa) : -1;
    int level = -1;
    RMAP_TRY(rmap_common_isa(context, &level, err));
    level = wanted >= 0 && wanted < level ? wanted : level;
    st = rmap_accel_create_isa(scene, context->n_thread, level, accel_ret, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    return st;
}

/* Collective. Rank 0 has opened the map, or failed. The first rank of each other node reads its
 * index and nothing else, and what is beside that comes from rank 0: ranks that all look for
 * themselves are too many for a file system, and of a map that is being traced each would see
 * another. The other ranks of a node read the scene, and have the rows of the first. */
static enum rmap_status join_map(const struct rmap_context *context, const char *path,
                                 enum rmap_status st, struct rmap_map **map, struct rmap_error *err)
{
    struct rmap_node node;
    bool same = true;
    if (context->size == 1)
        return st;
    const enum rmap_status found = rmap_node_init(&node, context, err);
    if (st == RMAP_OK)
        st = found;
    if (st == RMAP_OK && context->rank != 0)
        st = node.is_first ? rmap_map_open_listed(path, map, err)
                           : rmap_map_open_bare(path, "map.h5", map, err);
    RMAP_TRY(rmap_agree_patiently(context, st, err));
    if (node.is_first)
        st = same_on_all(&node.firsts, *map, &same, err);
    if (node.is_first && st == RMAP_OK && !same)
        st = send_state(&node.firsts, *map, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(share_in_node(context, &node, *map, err));
out:
    rmap_node_fini(&node);
    if (st != RMAP_OK) {
        rmap_map_close(*map);
        *map = NULL;
    }
    return st;
}

enum rmap_status rmap_load_map(const struct rmap_context *context, const char *path,
                               struct rmap_map **map_ret, struct rmap_error *err)
{
    struct rmap_map *map = NULL;
    if (at_hand_of(context, path)) {
        *map_ret = rmap_map_lend(context->at_hand->map);
        return RMAP_OK;
    }
    enum rmap_status st = context->rank == 0 ? rmap_map_open(path, &map, err) : RMAP_OK;
    st = join_map(context, path, st, &map, err);
    if (st != RMAP_OK)
        return st;
    warn_incomplete(context, path, map);
    *map_ret = map;
    return RMAP_OK;
}

enum rmap_status rmap_load_map_found(const struct rmap_context *context, const char *path,
                                     const struct rmap_map_listing *found,
                                     struct rmap_map **map_ret, struct rmap_error *err)
{
    *map_ret = NULL;
    enum rmap_status st =
        context->rank == 0 ? rmap_map_open_found(path, found, map_ret, err) : RMAP_OK;
    return join_map(context, path, st, map_ret, err);
}

void rmap_discard_map(const char *path, struct rmap_error *err)
{
    struct rmap_error why = {0};
    if (rmap_map_remove(path, &why) != RMAP_OK)
        rmap_error_context(err, "half of %s stays behind (%s)", path, why.text);
}
