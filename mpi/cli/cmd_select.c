/* SPDX-License-Identifier: MIT
 *
 * raymap select: rays that a map keeps by name, as criteria ask for by @NAME.
 */
#include <errno.h>
#include <string.h>
#include <unistd.h>

#include "analysis/query/id_fold.h"
#include "base/alloc.h"
#include "io/map/map_directory.h"
#include "io/map/map_json.h"
#include "io/map/map_lock.h"
#include "mpi/answer/named_rays_out.h"
#include "mpi/command/asked.h"
#include "mpi/command/json_out.h"
#include "mpi/command/load.h"
#include "mpi/parallel/agree.h"
#include "mpi/scan/fold_run.h"

static const struct rmap_option options[] = {
    {"force", 'f', NULL, "select again where the name is taken"},
    {"remove", 0, NULL, "let go of the rays of the name"},
    RMAP_ASKED_OPTIONS,
    {NULL}};

/* What --zemax and --criteria leave of the operands: MAP [NAME [CRITERION]]. */
struct request {
    const char *map, *name;
    const char *text[1];
    bool force, remove;
    struct rmap_asked asked;
};

static enum rmap_status read_request(const struct rmap_context *context,
                                     const struct rmap_arguments *given, struct request *request,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    *request = (struct request){.map = given->operand[0],
                                .name = given->n_operand > 1 ? given->operand[1] : NULL,
                                .text = {given->n_operand > 2 ? given->operand[2] : NULL},
                                .force = rmap_argument(given, "force") != NULL,
                                .remove = rmap_argument(given, "remove") != NULL};
    const size_t n_text = given->n_operand > 2;
    RMAP_TRY(rmap_asked_load(context, given, request->text, n_text, &request->asked, err));
    if (request->name)
        RMAP_TRY(rmap_rays_name_check(request->name, err));
    if (request->remove && (!request->name || request->asked.n > 0))
        return rmap_error_set(err, RMAP_USAGE, "--remove takes a map and a name alone");
    if (!request->remove && request->asked.n != (request->name != NULL))
        st = rmap_error_set(err, RMAP_USAGE,
                            "a name wants one criterion; usage: raymap select "
                            "MAP NAME 'CRITERION'; see: raymap select --help");
out:
    return st;
}

/* ---- rank 0 ---- */

static enum rmap_status list(const struct rmap_context *context, const struct rmap_map *map,
                             const char *path, struct rmap_error *err)
{
    struct rmap_named_rays_list list;
    enum rmap_status st = rmap_named_rays_list(map, &list, err);
    if (st == RMAP_OK && context->json)
        st = rmap_json_print(rmap_json_of_map(json_pack("{s:s, s:o}", "map", path, "selections",
                                                        rmap_named_rays_json(&list)),
                                              map),
                             stdout, err);
    else if (st == RMAP_OK && !context->quiet)
        rmap_named_rays_print(path, &list, stdout);
    rmap_named_rays_list_fini(&list);
    return st;
}

static enum rmap_status check_taken(const struct request *request, struct rmap_error *err)
{
    char *path = rmap_named_rays_path(request->map, request->name);
    enum rmap_status st = RMAP_OK;
    if (!path)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    else if (request->remove && unlink(path) != 0)
        st = errno == ENOENT ? rmap_error_set(err, RMAP_INPUT, "%s: no rays are named '%s'",
                                              request->map, request->name)
                             : rmap_error_set(err, RMAP_SYSTEM, "%s: cannot be removed: %s", path,
                                              strerror(errno));
    else if (!request->remove && !request->force && access(path, F_OK) == 0)
        st = rmap_error_set(err, RMAP_USAGE,
                            "%s: rays are named '%s' already; --force selects again", request->map,
                            request->name);
    rmap_free(path);
    return st;
}

static enum rmap_status keep(const struct request *request, const struct rmap_map *map,
                             const struct rmap_criterion *criterion, struct rmap_id_set *set,
                             struct rmap_error *err)
{
    char *words = NULL;
    enum rmap_status st = rmap_criterion_spell(criterion, request->asked.criteria, &words, err);
    rmap_id_set_settle(set);
    if (st == RMAP_OK)
        st = rmap_named_rays_write(map, request->name, words, set, err);
    rmap_free(words);
    return st;
}

/* ---- all ranks ---- */

/* Collective. */
static enum rmap_status select_rays(const struct rmap_context *context, struct request *request,
                                    const struct rmap_map *map, struct rmap_error *err)
{
    struct rmap_criterion *criterion = NULL;
    void *set = NULL;
    enum rmap_status st =
        rmap_asked_compile(context, &request->asked, 0, rmap_map_scene(map), &criterion, err);
    RMAP_TRY(rmap_agree(context, st, err));
    const struct rmap_fold fold = {.kind = &rmap_id_fold_kind,
                                   .map = map,
                                   .criterion = criterion,
                                   .columns = RMAP_COLUMN_BIT(RMAP_RAY_id)};
    RMAP_TRY(rmap_fold_run(context, &fold, &set, err));
    if (context->rank == 0)
        st = keep(request, map, criterion, set, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    if (set)
        rmap_id_fold_kind.destroy(set);
    rmap_criterion_destroy(criterion);
    return st;
}

static enum rmap_status run_select(const struct rmap_context *context,
                                   const struct rmap_arguments *given, struct rmap_error *err)
{
    struct request request;
    struct rmap_map *map = NULL;
    struct rmap_map_lock lock = {0};
    enum rmap_status st = read_request(context, given, &request, err);
    RMAP_TRY(rmap_agree(context, st, err));
    if (context->rank == 0 && request.name)
        st = rmap_map_lock_take(request.map, "select", &lock, err);
    if (st == RMAP_OK && lock.path)
        st = rmap_map_remove_half_indexes(request.map, err);
    RMAP_TRY(rmap_agree_patiently(context, st, err));
    RMAP_TRY(rmap_load_map(context, request.map, &map, err));
    if (context->rank == 0 && request.name)
        st = check_taken(&request, err);
    RMAP_TRY(rmap_agree(context, st, err));
    if (request.asked.n > 0)
        RMAP_TRY(select_rays(context, &request, map, err));
    if (context->rank == 0)
        st = list(context, map, request.map, err);
    st = rmap_agree(context, st, err);
out:
    rmap_map_close(map);
    rmap_map_lock_release(&lock);
    rmap_asked_fini(&request.asked);
    return st;
}

const struct rmap_command rmap_command_select = {
    .name = "select",
    .summary = "keep the rays that match in the map, by a name for criteria",
    .operands = "MAP [NAME 'CRITERION']",
    .help =
        "Finds the rays that match and keeps their ids in the map under a name, as\n\n"
        "  raymap select lens.raymap ghosts 'registered(sensor where ghost_order >= 1)'\n"
        "  raymap stats lens.raymap --of 'x(sensor)' --where '@ghosts and source(sun)'\n\n"
        "From then on @ghosts is a criterion of this map, everywhere, and is not judged again.\n"
        "A map alone lists what it keeps. Rays that were selected before more were traced are not\n"
        "used: --force selects again. Maps made of this one (query -o, convert, merge) have none.",
    .options = options,
    .min_operands = 1,
    .max_operands = 3,
    .run = run_select,
};
