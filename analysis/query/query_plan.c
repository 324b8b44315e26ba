/* SPDX-License-Identifier: MIT
 *
 * What a scan for one criterion would read, found out from summaries, and of compact portions from
 * paths and what stands beside them.
 */
#include "analysis/query/query_plan.h"

#include "analysis/criterion/criterion_tree.h"
#include "analysis/query/query_outcomes.h"
#include "io/map/map_cursor.h"

/* Bytes of a portion's columns, decoded. */
static uint64_t decoded_nbytes(const struct rmap_map *map, const struct rmap_portion_info *info,
                               rmap_column_set columns)
{
    uint64_t nbytes = 0;
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++) {
        const struct rmap_column_info *column = rmap_column_info((enum rmap_column)c);
        uint64_t width =
            c == RMAP_SEGMENT_colour ? (uint64_t)rmap_map_n_channel(map) : (uint64_t)column->width;
        if (columns & RMAP_COLUMN_BIT(c))
            nbytes += info->n_row[column->table] * width * rmap_element_nbytes(column->element);
    }
    return nbytes;
}

/* Where paths leave rays open, or none has been ruled out that is wanted whole, some may be traced
 * again. */
static enum rmap_status add_compact(struct rmap_query_plan *plan,
                                    struct rmap_query_outcomes *outcomes, rmap_column_set columns,
                                    rmap_column_set wanted, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_query_outlook outlook;
    struct rmap_cursor *cursor;
    rmap_column_set traced;
    bool told;
    RMAP_TRY(rmap_query_outcomes_cursor(outcomes, &cursor, err));
    RMAP_TRY(rmap_cursor_traced(cursor, &traced, err));
    RMAP_TRY(rmap_query_outcomes_foresee(outcomes, 0, &outlook, &told, err));
    plan->n_compact++;
    plan->n_retraced +=
        (columns & traced) && (wanted & traced ? outlook.n_possible : outlook.n_left) > 0;
    if (told) {
        plan->n_told_ray += outlook.n_ray;
        plan->n_left_ray += outlook.n_open;
        plan->n_traced_ray += columns & traced ? outlook.n_left : 0;
    }
out:
    return st;
}

enum rmap_status rmap_query_plan(const struct rmap_map *map, const struct rmap_criterion *criterion,
                                 rmap_column_set wanted, struct rmap_query_plan *plan,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_query_outcomes *outcomes = NULL;
    wanted &= rmap_columns_of_run(rmap_map_scene(map)->timed);
    const rmap_column_set columns = wanted | rmap_criterion_columns(criterion);
    *plan = (struct rmap_query_plan){0};
    RMAP_TRY(rmap_query_outcomes_create(map, &criterion, 1, 0, &outcomes, err));
    for (size_t p = 0; p < rmap_map_n_portion(map); p++) {
        const struct rmap_portion_info *info = rmap_map_portion(map, p);
        if (rmap_criterion_skips(criterion, info)) {
            plan->n_skipped++;
            continue;
        }
        plan->columns |= columns;
        plan->decoded_nbytes += decoded_nbytes(map, info, columns);
        if (!columns || rmap_map_piece(map, (size_t)info->piece)->encoding != RMAP_ENCODING_COMPACT)
            continue;
        RMAP_TRY(rmap_query_outcomes_enter(outcomes, p, err));
        RMAP_TRY(add_compact(plan, outcomes, columns, wanted, err));
    }
out:
    rmap_query_outcomes_destroy(outcomes);
    return st;
}
