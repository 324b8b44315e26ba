/* SPDX-License-Identifier: MIT
 *
 * A portion by the paths of its rays.
 */
#include "compact/damaged.h"
#include "compact/decode_paths.h"
#include "compact/lane.h"

/* Whether every number of a lane is the one that was predicted. */
static bool is_predicted(uint64_t modes, enum rmap_lane_id lane)
{
    return (modes >> (2 * lane) & 3) == RMAP_LANE_PREDICTED;
}

enum rmap_status rmap_compact_tell_header(const struct rmap_rows *rows,
                                          struct rmap_compact_told *told, struct rmap_error *err)
{
    const uint64_t *header = rows->data[RMAP_STREAM_pool64];
    if (rows->n_row[RMAP_COMPACT_POOL64] < RMAP_HEADER_COUNT)
        return rmap_portion_damaged("it has no header", err);
    const uint64_t modes = header[RMAP_HEADER_MODES];
    *told = (struct rmap_compact_told){.weigh_one = is_predicted(modes, RMAP_LANE_RAY_weight),
                                       .ids_run = is_predicted(modes, RMAP_LANE_RAY_id),
                                       .media_told = is_predicted(modes, RMAP_LANE_SEGMENT_medium),
                                       .first_ray = header[RMAP_HEADER_FIRST]};
    return RMAP_OK;
}

enum rmap_status rmap_compact_tell(const struct rmap_compact_model *model,
                                   const struct rmap_path_table *table,
                                   const struct rmap_rows *rows,
                                   const size_t n_row[RMAP_TABLE_COUNT],
                                   struct rmap_compact_told *told, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_own_paths own = rmap_own_paths(model, rows);
    if (rows->n_row[RMAP_COMPACT_RAY] != n_row[RMAP_TABLE_RAY])
        return rmap_portion_damaged("it has not as many rays as the index says", err);
    RMAP_TRY(rmap_compact_tell_header(rows, told, err));
    told->path = own.path;
    told->n_own = own.n;
    st = rmap_own_paths_check(&own, table, n_row, err);
out:
    return st;
}

enum rmap_status rmap_compact_decode_own(const struct rmap_compact_model *model,
                                         const struct rmap_rows *rows, struct rmap_portion *out,
                                         struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_own_paths own = rmap_own_paths(model, rows);
    const rmap_column_set columns =
        RMAP_COLUMNS_DISCRETE | RMAP_COLUMN_BIT(RMAP_RAY_id) | RMAP_COLUMN_BIT(RMAP_RAY_weight);
    const size_t n_row[RMAP_TABLE_HISTORY_COUNT] = {own.n, own.n_segment, own.n_registration};
    rmap_portion_clear(out);
    for (int t = 0; t < RMAP_TABLE_HISTORY_COUNT; t++)
        RMAP_TRY(rmap_portion_reserve(out, (enum rmap_table)t, n_row[t], columns, err));
    memcpy(out->n_row, n_row, sizeof n_row);
    rmap_own_paths_unfold(&own, out);
out:
    return st;
}
