/* SPDX-License-Identifier: MIT
 *
 * How much of its map a session keeps in memory.
 */
#include "mpi/session/session_status.h"
#include "io/map/map_json.h"

#include <stdio.h>

#include "io/map/map_keep.h"
#include "mpi/command/json_out.h"
#include "mpi/parallel/agree.h"

enum { BUDGET, TAKEN, COLUMNS, PATHS, KINDS };

static json_t *as_json(const uint64_t *sum)
{
    return json_pack("{s:{s:I, s:I, s:i, s:I, s:I}}", "memory", "budget", (json_int_t)sum[BUDGET],
                     "taken", (json_int_t)sum[TAKEN], "indexes", 0, "opened",
                     (json_int_t)sum[PATHS], "columns", (json_int_t)sum[COLUMNS]);
}

enum rmap_status rmap_session_status(const struct rmap_context *context, const struct rmap_map *map,
                                     uint64_t memory, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map_kept kept;
    rmap_map_kept(map, &kept);
    uint64_t sum[KINDS] = {memory, kept.taken, kept.columns, kept.paths};
    RMAP_TRY(
        RMAP_MPI(MPI_Allreduce(MPI_IN_PLACE, sum, KINDS, MPI_UINT64_T, MPI_SUM, context->comm)));
    if (context->rank == 0 && context->json)
        st = rmap_json_line(rmap_json_of_map(as_json(sum), map), stdout, err);
    else if (context->rank == 0)
        printf("in memory: %.1f MB of at most %.0f MB: columns %.1f, paths %.1f\n",
               1e-6 * (double)sum[TAKEN], 1e-6 * (double)sum[BUDGET], 1e-6 * (double)sum[COLUMNS],
               1e-6 * (double)sum[PATHS]);
    st = rmap_agree(context, st, err);
out:
    return st;
}
