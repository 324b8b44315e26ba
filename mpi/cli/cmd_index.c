/* SPDX-License-Identifier: MIT
 *
 * raymap index: what earlier versions made for fast questions. Maps answer them by themselves.
 */
#include <stdio.h>

#include "io/map/map_json.h"
#include "mpi/command/json_out.h"
#include "mpi/command/load.h"
#include "mpi/parallel/agree.h"

static const struct rmap_option options[] = {{"force", 'f', NULL, "accepted, without effect"},
                                             {"large", 0, NULL, "accepted, without effect"},
                                             {NULL}};

static enum rmap_status tell(const struct rmap_context *context, const char *path,
                             const struct rmap_map *map, struct rmap_error *err)
{
    struct rmap_map_summary summary;
    const json_int_t none = 0;
    rmap_map_summarise(map, &summary);
    if (!context->json) {
        if (!context->quiet)
            printf("%s: nothing to do: maps need no index\n", path);
        return RMAP_OK;
    }
    return rmap_json_print(
        rmap_json_of_map(json_pack("{s:s, s:I, s:I, s:I, s:I, s:I, s:I, s:f, s:f}", "map", path,
                                   "pieces", (json_int_t)rmap_map_n_piece(map), "made", none,
                                   "left", none, "left_bytes", none, "bytes", none, "map_bytes",
                                   (json_int_t)summary.nbytes, "share", 0.0, "seconds", 0.0),
                         map),
        stdout, err);
}

static enum rmap_status run_index(const struct rmap_context *context,
                                  const struct rmap_arguments *given, struct rmap_error *err)
{
    struct rmap_map *map = NULL;
    enum rmap_status st = rmap_load_map(context, given->operand[0], &map, err);
    if (st == RMAP_OK && context->rank == 0)
        st = tell(context, given->operand[0], map, err);
    st = rmap_agree(context, st, err);
    rmap_map_close(map);
    return st;
}

const struct rmap_command rmap_command_index = {
    .name = "index",
    .summary = "nothing to do: maps need no index",
    .operands = "MAP",
    .help =
        "Earlier versions wrote beside the pieces of a map what fast questions needed. The pieces\n"
        "themselves hold that now: the command is accepted and does nothing, as is --index of\n"
        "`raymap trace`. Files of old indexes are not read; `raymap info` names them, `raymap\n"
        "repair` removes them.",
    .options = options,
    .min_operands = 1,
    .max_operands = 1,
    .run = run_index,
};
