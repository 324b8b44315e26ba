/* SPDX-License-Identifier: MIT
 *
 * raymap index: what the rays of a map met, in a form that questions are answered from at once.
 */
#include "mpi/agree.h"
#include "mpi/index_run.h"
#include "mpi/json_out.h"

static const struct rmap_option options[] = {
    {"force", 'f', NULL, "make also those again that are there and good"}, {NULL}};

static enum rmap_status tell(const struct rmap_context *context, const char *path,
                             const struct rmap_index_result *result, struct rmap_error *err)
{
    double share =
        result->map_nbytes > 0 ? (double)result->nbytes / (double)result->map_nbytes : 0.0;
    if (context->json)
        return rmap_json_print(
            json_pack("{s:s, s:I, s:I, s:I, s:I, s:f, s:f}", "map", path, "pieces",
                      (json_int_t)result->n_piece, "made", (json_int_t)result->n_made, "bytes",
                      (json_int_t)result->nbytes, "map_bytes", (json_int_t)result->map_nbytes,
                      "share", share, "seconds", result->seconds),
            stdout, err);
    if (!context->quiet)
        printf("%s: history indexes of %llu pieces, %llu of them made now: %.1f MB, %.1f %% of the "
               "map\n",
               path, (unsigned long long)result->n_piece, (unsigned long long)result->n_made,
               1e-6 * (double)result->nbytes, 100.0 * share);
    return RMAP_OK;
}

static enum rmap_status run_index(const struct rmap_context *context,
                                  const struct rmap_arguments *given, struct rmap_error *err)
{
    struct rmap_index_result result;
    enum rmap_status st = rmap_index_run(context, given->operand[0],
                                         rmap_argument(given, "force") != NULL, &result, err);
    if (st == RMAP_OK && context->rank == 0)
        st = tell(context, given->operand[0], &result, err);
    return rmap_agree(context, st, err);
}

const struct rmap_command rmap_command_index = {
    .name = "index",
    .summary = "prepare a map for fast questions",
    .operands = "MAP",
    .help = "Writes beside each piece of a map what its rays met and where they were registered,\n"
            "without positions, in a form that questions are answered from many times faster than\n"
            "from the columns. It takes some per cent of a plain map. Answers are the same with\n"
            "and without; what is deleted of it can be made again. Pieces that have one are\n"
            "passed over. Runs on all ranks and threads. `raymap trace --index` does the same at\n"
            "the end of a trace.",
    .options = options,
    .min_operands = 1,
    .max_operands = 1,
    .run = run_index,
};
