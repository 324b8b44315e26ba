/* SPDX-License-Identifier: MIT
 *
 * The rays of a portion that its history leaves undecided: discrete columns from the index,
 * measured ones from the map, each when first asked for. A few rays are gathered into a small
 * portion of their own; many stay among the others.
 */
#ifndef RMAP_QUERY_UNDECIDED_H
#define RMAP_QUERY_UNDECIDED_H

#include "analysis/query/query_history.h"

/* Zero it at first. */
struct rmap_undecided {
    bool is_whole; /* all rays of the portion in hand, decided ones among them */
    size_t n;
    uint32_t *ray; /* [n] rows of /ray of the portion in hand, ascending; not set for the whole */
    size_t ray_cap;
    struct rmap_portion rows; /* of these rays: counted, columns as far as fetched */

    const struct rmap_history_view *view;
    struct rmap_query_history *history;
    struct rmap_cursor *cursor;          /* at the portion in hand */
    const struct rmap_portion *measured; /* what it reads */
    struct rmap_portion *memory;         /* of the columns */
    rmap_column_set present;
    bool is_placed[RMAP_TABLE_HISTORY_COUNT];
    struct rmap_row_range *range[RMAP_TABLE_HISTORY_COUNT]; /* [n] of each ray */
    size_t range_cap[RMAP_TABLE_HISTORY_COUNT];
};
void rmap_undecided_fini(struct rmap_undecided *undecided);

/* Takes the rays whose outcome is open: [view->n_path] outcomes for PATHS, [n_ray] for ROWS. The
 * others are borrowed until the next call. */
enum rmap_status rmap_undecided_enter(struct rmap_undecided *undecided, const uint8_t *outcome,
                                      const struct rmap_history_view *view,
                                      struct rmap_query_history *history,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* As rmap_criterion_input.fetch; context: a struct rmap_undecided whose cursor and measured portion
 * are set. */
enum rmap_status rmap_undecided_fetch(void *context, rmap_column_set columns,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
