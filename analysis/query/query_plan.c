/* SPDX-License-Identifier: MIT
 *
 * What a scan for one criterion would read, found out from summaries, the history index, and the
 * paths of compact portions.
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

/* Columns that a portion is asked for. */
static rmap_column_set columns_of(const struct rmap_criterion *criterion,
                                  const struct rmap_query_outlook *outlook, bool rays_wanted)
{
    rmap_column_set columns = rmap_criterion_columns(criterion);
    if (rays_wanted && outlook->n_possible > 0)
        return RMAP_COLUMNS_ALL;
    if (!outlook->view)
        return columns;
    if (outlook->view->relative)
        columns &= ~RMAP_COLUMN_BIT(RMAP_REGISTRATION_relative);
    return outlook->n_open > 0 ? columns & ~RMAP_COLUMNS_DISCRETE : 0;
}

static void add_portion(struct rmap_query_plan *plan, const struct rmap_query_outlook *outlook)
{
    if (!outlook->view) {
        plan->n_by_column++;
        return;
    }
    plan->n_by_path += outlook->view->form == RMAP_HISTORY_PATHS;
    plan->n_by_row += outlook->view->form != RMAP_HISTORY_PATHS;
    plan->n_index_ray += outlook->view->n_row[RMAP_TABLE_RAY];
    plan->n_open_ray += outlook->n_open;
    plan->n_open_portion += outlook->n_open > 0;
    plan->index_nbytes += outlook->view->nbytes;
}

/* Where paths leave rays open, or none has been ruled out that is wanted whole, some may be traced
 * again. */
static enum rmap_status add_compact(struct rmap_query_plan *plan,
                                    struct rmap_query_outcomes *outcomes,
                                    struct rmap_query_outlook *outlook, rmap_column_set columns,
                                    bool rays_wanted, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_cursor *cursor;
    rmap_column_set traced;
    bool told;
    RMAP_TRY(rmap_query_outcomes_cursor(outcomes, &cursor, err));
    RMAP_TRY(rmap_cursor_traced(cursor, &traced, err));
    RMAP_TRY(rmap_query_outcomes_foresee_paths(outcomes, 0, outlook, &told, err));
    plan->n_compact++;
    plan->n_retraced +=
        (columns & traced) && (rays_wanted ? outlook->n_possible : outlook->n_open) > 0;
    if (told) {
        plan->n_told_ray += outlook->n_ray;
        plan->n_left_ray += outlook->n_open;
    }
out:
    return st;
}

enum rmap_status rmap_query_plan(const struct rmap_map *map, const struct rmap_criterion *criterion,
                                 bool rays_wanted, struct rmap_query_plan *plan,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_query_outcomes *outcomes = NULL;
    const bool wanted = true;
    *plan = (struct rmap_query_plan){0};
    RMAP_TRY(rmap_query_outcomes_create(map, &criterion, 1, 0, &outcomes, err));
    for (size_t p = 0; p < rmap_map_n_portion(map); p++) {
        const struct rmap_portion_info *info = rmap_map_portion(map, p);
        struct rmap_query_outlook outlook;
        if (rmap_criterion_skips(criterion, info)) {
            plan->n_skipped++;
            continue;
        }
        RMAP_TRY(rmap_query_outcomes_enter(outcomes, p, &wanted, err));
        rmap_query_outcomes_foresee(outcomes, 0, &outlook);
        add_portion(plan, &outlook);
        const rmap_column_set columns = columns_of(criterion, &outlook, rays_wanted);
        plan->columns |= columns;
        plan->decoded_nbytes += decoded_nbytes(map, info, columns);
        if (columns && rmap_map_piece(map, (size_t)info->piece)->encoding == RMAP_ENCODING_COMPACT)
            RMAP_TRY(add_compact(plan, outcomes, &outlook, columns, rays_wanted, err));
    }
out:
    rmap_query_outcomes_destroy(outcomes);
    return st;
}
