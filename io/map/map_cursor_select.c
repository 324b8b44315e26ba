/* SPDX-License-Identifier: MIT
 *
 * Some rays of a portion, decoded without the others; columns beside a piece against those in it.
 */
#include <string.h>

#include "base/alloc.h"
#include "base/byte_set.h"
#include "base/count.h"
#include "io/map/map_cursor_internal.h"
#include "io/map/map_keep.h"
#include "io/map/piece_columns.h"

/* Where rays are selected, at most one of so many: selecting one costs as much as some that are
 * traced again with all others; and as much as reading many where the columns stand beside. */
enum { SELECTED_SHARE = 2, BESIDE_SHARE = 16 };

bool rmap_map_selects(const struct rmap_map *map, size_t portion, rmap_column_set columns)
{
    const struct rmap_portion_info *info = &map->content.portion[portion];
    struct rmap_map_kept kept;
    rmap_map_kept(map, &kept);
    return map->content.piece[info->piece].encoding == RMAP_ENCODING_COMPACT &&
           (columns & rmap_compact_traced(false)) && kept.budget == 0 &&
           !((columns & RMAP_COLUMNS_CURVE) && info->n_row[RMAP_TABLE_CURVE] > 0);
}

enum rmap_status rmap_cursor_compare_beside(struct rmap_cursor *self, enum rmap_column *differs_ret,
                                            struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion_info *info = &self->map->content.portion[self->in_hand];
    const rmap_column_set columns = rmap_map_columns_beside(self->map, (size_t)info->piece);
    *differs_ret = RMAP_COLUMN_COUNT;
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++) {
        const enum rmap_table table = rmap_column_info((enum rmap_column)c)->table;
        const size_t n = self->shown.n_row[table];
        const size_t nbytes = n * rmap_portion_row_nbytes(&self->shown, (enum rmap_column)c);
        if (!(columns & RMAP_COLUMN_BIT(c)) || nbytes == 0)
            continue;
        RMAP_TRY(rmap_reserve(&self->beside.data, &self->beside.cap, nbytes, 1, err));
        RMAP_TRY(rmap_chunk_reader_kept(self->reader, (size_t)info->piece, c,
                                        rmap_map_first_rows(self->map, self->in_hand)[table], n,
                                        self->beside.data, err));
        if (memcmp(self->beside.data, rmap_portion_column(&self->shown, (enum rmap_column)c),
                   nbytes) != 0)
            *differs_ret = (enum rmap_column)c;
    }
out:
    return st;
}

/* Whether the n rays that are marked are among those selected last. */
static bool are_selected(const struct rmap_cursor_selected *selected, const uint8_t *mark,
                         uint8_t wanted, size_t n, rmap_column_set columns)
{
    size_t count = 0;
    if (columns & ~selected->columns)
        return false;
    for (size_t s = 0; s < selected->shown.n_row[RMAP_TABLE_RAY]; s++)
        count += mark[selected->ray[s]] == wanted;
    return count == n;
}

/* Decodes n rays into what the space has for such a selection. */
static enum rmap_status decode_selected(struct rmap_cursor *self,
                                        const struct rmap_portion_info *info, int which, size_t n,
                                        rmap_column_set columns, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_cursor_space *space = &self->space[info->space];
    struct rmap_portion **rays = &space->selected[which];
    struct rmap_cursor_rows in_hand;
    const struct rmap_rows *rows = NULL;
    size_t n_row[RMAP_TABLE_COUNT];
    self->whole_paths = true;
    RMAP_TRY(rmap_cursor_enter_rows(
        self, info, rmap_compact_selection_streams(columns, &self->header), &in_hand, err));
    RMAP_TRY(rmap_cursor_make_decoder(self, info, err));
    if (!space->selection)
        RMAP_TRY(rmap_compact_selection_create(in_hand.model, &space->selection, err));
    if (!*rays)
        RMAP_TRY(rmap_portion_create(0, self->portion->n_channel, rays, err));
    st = rmap_compact_select(space->selection, self->paths, &in_hand.rows, in_hand.n_row, columns,
                             self->selected[which].ray, n, &rows, n_row, err);
    rmap_compact_decoder_pass_over(space->decoder, NULL);
    if (st == RMAP_OK)
        st = rmap_compact_decode(space->decoder, self->paths, rows, n_row, columns, 0, *rays, err);
    if (st != RMAP_OK)
        rmap_cursor_say_where(self, info, err);
out:
    return st;
}

enum rmap_status rmap_cursor_select(struct rmap_cursor *self, const uint8_t *mark, uint8_t wanted,
                                    rmap_column_set columns,
                                    const struct rmap_portion **selected_ret,
                                    const uint32_t **ray_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion_info *info = &self->map->content.portion[self->in_hand];
    const size_t n_ray = self->shown.n_row[RMAP_TABLE_RAY];
    *selected_ret = NULL;
    columns &= rmap_columns_known(self->shown.timed);
    if (self->is_narrow || !rmap_map_selects(self->map, self->in_hand, columns) ||
        !(columns & ~self->present & rmap_compact_traced(false)))
        return RMAP_OK;
    rmap_column_set beside;
    RMAP_TRY(rmap_cursor_know_header(self, err));
    RMAP_TRY(rmap_cursor_choose_beside(self, info, columns & ~self->present, &beside, err));
    const size_t n = rmap_count_equal(mark, n_ray, wanted);
    if (n == 0 || n * (beside ? BESIDE_SHARE : SELECTED_SHARE) > n_ray)
        goto out;
    const rmap_column_set standing = rmap_map_columns_beside(self->map, (size_t)info->piece);
    const int which = (columns & rmap_compact_traced(self->header.placed) & ~standing) != 0;
    struct rmap_cursor_selected *selected = &self->selected[which];
    struct rmap_portion *shown = &selected->shown;
    if (are_selected(selected, mark, wanted, n, columns))
        goto selected;
    selected->columns = 0;
    RMAP_TRY(RMAP_RESERVE(selected->ray, selected->cap, n_ray, err));
    rmap_bytes_list(mark, n_ray, wanted, selected->ray);
    RMAP_TRY(decode_selected(self, info, which, n, columns, err));
    const struct rmap_portion *rows = self->space[info->space].selected[which];
    *shown = (struct rmap_portion){.n_channel = rows->n_channel,
                                   .timed = rows->timed,
                                   .first_ray = rows->first_ray,
                                   .unpredicted = rows->unpredicted};
    memcpy(shown->n_row, rows->n_row, sizeof rows->n_row);
    rmap_cursor_show_columns(rows, columns, shown);
    RMAP_TRY(rmap_cursor_check_limits(self, shown, columns, info, err));
    if ((columns & RMAP_CELL_COLUMNS) == RMAP_CELL_COLUMNS)
        RMAP_TRY(rmap_cursor_check_cells(self, shown, err));
    selected->columns = columns;
selected:
    *selected_ret = shown;
    *ray_ret = selected->ray;
out:
    return st;
}
