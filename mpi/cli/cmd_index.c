/* SPDX-License-Identifier: MIT
 *
 * raymap index: what the rays of a map met, in a form that questions are answered from at once.
 */
#include "base/grouped.h"
#include "io/map/map_directory.h"
#include "io/map/map_json.h"
#include "io/map/map_lock.h"
#include "io/map/map_reader.h"
#include "mpi/command/json_out.h"
#include "mpi/parallel/agree.h"
#include "mpi/scan/index_run.h"

static const struct rmap_option options[] = {
    {"force", 'f', NULL, "make also those again that are there and good"},
    {"large", 0, NULL, "make also those that take more than a tenth of the map"},
    {NULL}};

static enum rmap_status tell(const struct rmap_context *context, const char *path,
                             const struct rmap_index_result *result, struct rmap_error *err)
{
    char line[256];
    double share =
        result->map_nbytes > 0 ? (double)result->nbytes / (double)result->map_nbytes : 0.0;
    if (context->json) {
        struct rmap_map *map = NULL;
        enum rmap_status st = rmap_map_open(path, &map, err);
        if (st != RMAP_OK)
            return st;
        json_t *document = rmap_json_of_map(
            json_pack("{s:s, s:I, s:I, s:I, s:I, s:I, s:I, s:f, s:f}", "map", path, "pieces",
                      (json_int_t)result->n_piece, "made", (json_int_t)result->n_made, "left",
                      (json_int_t)result->n_large, "left_bytes", (json_int_t)result->large_nbytes,
                      "bytes", (json_int_t)result->nbytes, "map_bytes",
                      (json_int_t)result->map_nbytes, "share", share, "seconds", result->seconds),
            map);
        rmap_map_close(map);
        return rmap_json_print(document, stdout, err);
    }
    if (!context->quiet)
        printf("%s: history indexes of %s, %llu of them made now: %.1f MB, %.1f %% of the "
               "map\n",
               path, rmap_counted(result->n_piece, "piece").text,
               (unsigned long long)result->n_made, 1e-6 * (double)result->nbytes, 100.0 * share);
    rmap_index_tell_large(result, line, sizeof line);
    if (!context->quiet && line[0])
        printf("%s: %s\n", path, line);
    return RMAP_OK;
}

static enum rmap_status run_index(const struct rmap_context *context,
                                  const struct rmap_arguments *given, struct rmap_error *err)
{
    struct rmap_index_result result;
    int flags = (rmap_argument(given, "force") ? RMAP_INDEX_REMAKE : 0) |
                (rmap_argument(given, "large") ? RMAP_INDEX_LARGE : 0);
    enum rmap_status st = RMAP_OK;
    struct rmap_map_lock lock = {0};
    if (context->rank == 0)
        st = rmap_map_lock_take(given->operand[0], "index", &lock, err);
    if (st == RMAP_OK && lock.path)
        st = rmap_map_remove_half_indexes(given->operand[0], err);
    RMAP_TRY(rmap_agree_patiently(context, st, err));
    RMAP_TRY(rmap_index_run(context, given->operand[0], flags, &result, err));
    if (context->rank == 0)
        st = tell(context, given->operand[0], &result, err);
    st = rmap_agree(context, st, err);
out:
    rmap_map_lock_release(&lock);
    return st;
}

const struct rmap_command rmap_command_index = {
    .name = "index",
    .summary = "prepare a map for fast questions",
    .operands = "MAP",
    .help =
        "Writes beside each piece of a map what its rays met and where they were registered,\n"
        "without positions, in a form that questions are answered from many times faster than\n"
        "from the columns. It takes some per cent of a plain map. Where it would take more than\n"
        "a tenth of the map, as in compact ones, --large makes it all the same. Answers are the\n"
        "same with and without; what is deleted of it can be made again. Pieces that have one\n"
        "are passed over. Runs on all ranks and threads. `raymap trace --index` does the same\n"
        "at the end of a trace.",
    .options = options,
    .min_operands = 1,
    .max_operands = 1,
    .run = run_index,
};
