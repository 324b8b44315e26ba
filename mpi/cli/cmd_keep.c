/* SPDX-License-Identifier: MIT
 *
 * raymap keep: numbers worked out once and kept in a compact map.
 */
#include <errno.h>
#include <string.h>

#include "analysis/query/quantity.h"
#include "base/alloc.h"
#include "base/grouped.h"
#include "io/file/directory.h"
#include "io/file/publish.h"
#include "io/map/map_directory.h"
#include "io/map/map_json.h"
#include "io/map/map_lock.h"
#include "mpi/answer/kept_columns_out.h"
#include "mpi/command/json_out.h"
#include "mpi/command/load.h"
#include "mpi/parallel/agree.h"
#include "mpi/scan/keep_run.h"

static const struct rmap_option options[] = {
    {"of", 0, "NUMBER", "as of stats: path_length, 'angle(sensor)' ...; may stand several times"},
    {"force", 'f', NULL, "also where it is kept already, and in place of damaged files"},
    {"remove", 0, NULL, "let go of all that is kept"},
    {NULL}};

struct request {
    const char *map;
    char **of; /* [n_of] */
    size_t n_of;
    bool force, remove;
};

static enum rmap_status read_request(const struct rmap_arguments *given, struct request *request,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    request->map = given->operand[0];
    request->force = rmap_argument(given, "force") != NULL;
    request->remove = rmap_argument(given, "remove") != NULL;
    RMAP_TRY(rmap_argument_each(given, "of", &request->of, &request->n_of, err));
    if (request->remove && (request->n_of > 0 || request->force))
        return rmap_error_set(err, RMAP_USAGE, "--remove stands alone");
    if (request->force && request->n_of == 0)
        st = rmap_error_set(err, RMAP_USAGE, "--force goes with --of: keep which number?");
out:
    return st;
}

/* Columns that the numbers are made of and that rays are traced again for. Rank 0 says of which
 * numbers there are none. */
static enum rmap_status choose(const struct rmap_context *context, const struct rmap_map *map,
                               const struct request *request, rmap_column_set *columns_ret,
                               struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < request->n_of; i++) {
        struct rmap_quantities *quantities = NULL;
        RMAP_TRY(rmap_quantities_create(map, (const char *const *)&request->of[i], 1, NULL,
                                        &quantities, err));
        const rmap_column_set columns = quantities->columns & rmap_keepable_columns();
        rmap_quantities_destroy(quantities);
        *columns_ret |= columns;
        if (!columns && context->rank == 0 && !context->quiet)
            fprintf(stderr, "raymap: %s stands in the map as it is: nothing to keep\n",
                    request->of[i]);
    }
out:
    return st;
}

/* What killed runs left of files that they were writing; the map's lock is held. */
static enum rmap_status remove_halves(const char *map_path, struct rmap_error *err)
{
    struct rmap_map_listing found;
    enum rmap_status st = rmap_map_list(map_path, &found, err);
    for (size_t i = 0; st == RMAP_OK && i < found.n_leftover; i++) {
        const struct rmap_leftover *leftover = &found.leftover[i];
        if (leftover->has_journal || !strstr(leftover->name, RMAP_COLUMNS_SUFFIX "."))
            continue;
        char *path = rmap_path_format("%s/%s", map_path, leftover->name);
        if (!path)
            st = rmap_error_set(err, RMAP_SYSTEM, "out of memory");
        else
            (void)!rmap_shard_unlink(path); /* harmless where it cannot be removed */
        rmap_free(path);
    }
    rmap_map_listing_fini(&found);
    return st;
}

static enum rmap_status remove_all(const struct rmap_map *map, const char *map_path,
                                   struct rmap_error *err)
{
    for (size_t i = 0; i < rmap_map_n_piece(map); i++) {
        char *path = rmap_piece_columns_path(map_path, rmap_map_piece(map, i));
        enum rmap_status st = RMAP_OK;
        if (!path)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
        if (rmap_shard_unlink(path) != 0 && errno != ENOENT)
            st = rmap_error_set(err, RMAP_SYSTEM, "%s: cannot be removed: %s", path,
                                strerror(errno));
        rmap_free(path);
        if (st != RMAP_OK)
            return st;
    }
    return RMAP_OK;
}

static enum rmap_status tell(const struct rmap_context *context, const struct request *request,
                             const struct rmap_map *map, const struct rmap_keep_result *result,
                             struct rmap_error *err)
{
    struct rmap_columns_survey survey;
    enum rmap_status st = rmap_map_columns_survey(map, &survey, err);
    if (st == RMAP_OK && context->json)
        return rmap_json_print(
            rmap_json_of_map(json_pack("{s:s, s:I, s:o, s:f}", "map", request->map, "made",
                                       (json_int_t)result->n_made, "kept",
                                       rmap_kept_columns_json(&survey), "seconds", result->seconds),
                             map),
            stdout, err);
    if (st != RMAP_OK || context->quiet)
        return st;
    if (survey.n_piece + survey.n_unused == 0)
        printf("%s: nothing is kept%s\n", request->map,
               survey.n_compact == 0 ? ": the columns of plain pieces stand as they are" : "");
    else
        printf("%s: %s written now\n", request->map, rmap_counted(result->n_made, "piece").text);
    rmap_kept_columns_print(&survey, stdout);
    return RMAP_OK;
}

static enum rmap_status run_keep(const struct rmap_context *context,
                                 const struct rmap_arguments *given, struct rmap_error *err)
{
    struct request request = {0};
    struct rmap_map *map = NULL;
    struct rmap_map_lock lock = {0};
    struct rmap_keep_result result = {0};
    rmap_column_set columns = 0;
    enum rmap_status st = read_request(given, &request, err);
    RMAP_TRY(rmap_agree(context, st, err));
    const bool changes = request.n_of > 0 || request.remove;
    if (context->rank == 0 && changes)
        st = rmap_map_lock_take(request.map, "keep", &lock, err);
    if (st == RMAP_OK && lock.path)
        st = remove_halves(request.map, err);
    RMAP_TRY(rmap_agree_patiently(context, st, err));
    RMAP_TRY(rmap_load_map(context, request.map, &map, err));
    st = choose(context, map, &request, &columns, err);
    if (st == RMAP_OK && context->rank == 0 && request.remove)
        st = remove_all(map, request.map, err);
    RMAP_TRY(rmap_agree(context, st, err));
    if (columns)
        RMAP_TRY(rmap_keep_run(context, map, columns, request.force, &result, err));
    if (context->rank == 0)
        st = tell(context, &request, map, &result, err);
    st = rmap_agree(context, st, err);
out:
    rmap_argument_list_free(request.of, request.n_of);
    rmap_map_close(map);
    rmap_map_lock_release(&lock);
    return st;
}

const struct rmap_command rmap_command_keep = {
    .name = "keep",
    .summary = "work out numbers once and keep them in a compact map",
    .operands = "MAP [--of NUMBER ...]",
    .help =
        "A compact map knows lengths, angles, times and positions by tracing rays again. Numbers\n"
        "that are asked for often are worked out once and kept beside its pieces, as\n\n"
        "  mpirun -np 4 raymap keep lens.raymap --of path_length --of 'angle(sensor)'\n\n"
        "Criteria, statistics and images then read them; answers are the same, bit for bit. What\n"
        "is kept are the columns of the map that a number is made of, exact. A map alone tells\n"
        "what is kept. After --append, keep again: pieces that have the columns are passed over.",
    .options = options,
    .min_operands = 1,
    .max_operands = 1,
    .run = run_keep,
};
