/* SPDX-License-Identifier: MIT
 *
 * Decoded portions of the pieces of a map, one after the other.
 */
#include "base/alloc.h"
#include "io/map/map_chunks.h"
#include "io/map/map_cursor_internal.h"
#include "io/map/map_held.h"
#include "io/map/map_keep.h"
#include "io/map/piece_columns.h"

enum rmap_status rmap_cursor_create(const struct rmap_map *map, rmap_column_set columns,
                                    struct rmap_cursor **cursor_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_cursor *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a cursor");
    self->map = map;
    self->columns = columns & rmap_columns_known(map->scene[0]->timed);
    self->whole_paths = rmap_compact_needs_rows(self->columns);
    self->space = rmap_alloc(map->spaces.n, sizeof *self->space);
    if (!self->space) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a cursor");
        goto out;
    }
    RMAP_TRY(rmap_chunk_reader_create(map, &self->reader, err));
    *cursor_ret = self;
    self = NULL;
out:
    rmap_cursor_destroy(self);
    return st;
}

void rmap_cursor_destroy(struct rmap_cursor *self)
{
    if (!self)
        return;
    for (size_t i = 0; self->space && i < self->map->spaces.n; i++) {
        rmap_portion_destroy(self->space[i].portion);
        for (int k = 0; k < RMAP_CURSOR_SELECTIONS; k++)
            rmap_portion_destroy(self->space[i].selected[k]);
        rmap_compact_selection_destroy(self->space[i].selection);
        rmap_compact_decoder_destroy(self->space[i].decoder);
    }
    for (int s = 0; s < RMAP_STREAM_MAX; s++)
        rmap_free(self->buffer[s].data);
    rmap_cursor_leave_paths(self, SIZE_MAX);
    rmap_portion_destroy(self->own);
    rmap_free(self->steps.class);
    rmap_chunk_reader_destroy(self->reader);
    rmap_free(self->space);
    rmap_free(self->beside.data);
    for (int k = 0; k < RMAP_CURSOR_SELECTIONS; k++)
        rmap_free(self->selected[k].ray);
    rmap_free(self->own_sum);
    rmap_arrivals_fini(&self->arrivals);
    rmap_free(self);
}

uint64_t rmap_cursor_nbytes(const struct rmap_cursor *self)
{
    return rmap_chunk_reader_nbytes(self->reader);
}

uint64_t rmap_cursor_nbytes_of_rows(const struct rmap_cursor *self)
{
    return rmap_chunk_reader_nbytes_of_rows(self->reader);
}

/* Takes the portion of a colour space in hand, empty. */
static enum rmap_status enter_space(struct rmap_cursor *self, size_t space, struct rmap_error *err)
{
    struct rmap_portion **portion = &self->space[space].portion;
    if (!*portion) {
        *portion = rmap_alloc(1, sizeof **portion);
        if (!*portion)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a cursor");
        (*portion)->n_channel = self->map->spaces.space[space].n_channel;
        (*portion)->timed = self->map->scene[space]->timed;
    }
    self->portion = *portion;
    rmap_portion_clear(self->portion);
    return RMAP_OK;
}

/* Columns that stand as they are: the streams of a plain piece, or beside a compact one. */
static enum rmap_status read_plain(struct rmap_cursor *self, const struct rmap_portion_info *info,
                                   bool is_beside, rmap_column_set columns, struct rmap_error *err)
{
    const uint64_t *first = is_beside ? rmap_map_first_rows(self->map, self->in_hand) : NULL;
    enum rmap_status st = RMAP_OK;
    struct rmap_portion *rows = self->portion;
    bool has[RMAP_TABLE_COUNT] = {false};
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        has[rmap_column_info((enum rmap_column)c)->table] |= (columns & RMAP_COLUMN_BIT(c)) != 0;
    for (int t = 0; t < RMAP_TABLE_COUNT; t++) {
        rows->n_row[t] = 0;
        if (has[t])
            RMAP_TRY(rmap_portion_reserve(rows, (enum rmap_table)t, (size_t)info->n_row[t],
                                          columns | self->present, err));
    }
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        rows->n_row[t] = (size_t)info->n_row[t];
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++) {
        enum rmap_table table = rmap_column_info((enum rmap_column)c)->table;
        if (!(columns & RMAP_COLUMN_BIT(c)))
            continue;
        void *to = rmap_portion_column(self->portion, (enum rmap_column)c);
        const int stored =
            rmap_map_piece_layout(self->map, (size_t)info->piece)->stream[is_beside ? 0 : c].table;
        if (is_beside)
            RMAP_TRY(rmap_chunk_reader_kept(self->reader, (size_t)info->piece, c, first[table],
                                            rows->n_row[table], to, err));
        else
            RMAP_TRY(rmap_chunk_reader_rows(self->reader, (size_t)info->piece, c,
                                            info->stored_first[stored], rows->n_row[table], to,
                                            err));
    }
out:
    return st;
}

enum rmap_status rmap_cursor_enter(struct rmap_cursor *self, size_t portion,
                                   const struct rmap_portion **portion_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion_info *info = &self->map->content.portion[portion];
    const struct rmap_piece_chunks *chunks;
    self->present = 0;
    self->kept = 0;
    self->streams = 0;
    self->passed_over = NULL;
    self->in_hand = portion;
    self->own_columns = 0;
    self->knows_header = self->add_up = self->is_narrow = false;
    for (int k = 0; k < RMAP_CURSOR_SELECTIONS; k++)
        self->selected[k].columns = 0;
    self->header = (struct rmap_compact_summary){.placed = false};
    rmap_cursor_leave_paths(self, (size_t)info->piece);
    RMAP_TRY(enter_space(self, (size_t)info->space, err));
    /* The piece's chunks vouch for its rows before memory is taken for them. */
    if (!self->map->held)
        RMAP_TRY(rmap_map_piece_chunks(self->map, (size_t)info->piece, &chunks, err));
    self->portion->first_ray = info->first_ray;
    self->shown = *self->portion;
    self->shown.unpredicted = NULL;
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        self->shown.n_row[t] = (size_t)info->n_row[t];
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        *rmap_portion_column_address(&self->shown, (enum rmap_column)c) = NULL;
    *portion_ret = &self->shown;
out:
    return st;
}

void rmap_cursor_show_columns(const struct rmap_portion *rows, rmap_column_set columns,
                              struct rmap_portion *shown)
{
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (columns & RMAP_COLUMN_BIT(c))
            *rmap_portion_column_address(shown, (enum rmap_column)c) =
                rmap_portion_column(rows, (enum rmap_column)c);
    if (columns & RMAP_COLUMNS_ANGLES) {
        shown->knows_angles = rows->knows_angles;
        shown->angle = rows->angle;
    }
}

/* What is decoded when columns are asked for: rays are gone through once for all that their paths
 * say, and traced again once. */
static rmap_column_set compact_columns(const struct rmap_cursor *self, rmap_column_set columns)
{
    if (columns & rmap_compact_traced(self->header.placed))
        columns |= self->columns;
    if (columns & RMAP_COLUMNS_DISCRETE)
        columns |= self->columns & RMAP_COLUMNS_DISCRETE;
    return columns & ~self->present;
}

enum rmap_status rmap_cursor_choose_beside(struct rmap_cursor *self,
                                           const struct rmap_portion_info *info,
                                           rmap_column_set columns, rmap_column_set *beside_ret,
                                           struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_piece_columns *kept;
    const rmap_column_set traced =
        rmap_compact_traced(self->header.placed) & rmap_columns_of_run(self->shown.timed);
    *beside_ret = 0;
    /* Who wants none of them does not look for the file, and who wants all has them from the piece.
     */
    if ((columns & traced) == 0 || (traced & ~self->columns) == 0)
        return RMAP_OK;
    RMAP_TRY(rmap_map_piece_columns(self->map, (size_t)info->piece, &kept, err));
    *beside_ret = kept ? columns & kept->columns : 0;
    if (columns & traced & ~*beside_ret)
        *beside_ret = 0;
out:
    return st;
}

void rmap_cursor_pass_over(struct rmap_cursor *self, const uint8_t *mark)
{
    self->passed_over = mark;
}

static enum rmap_status read_columns(struct rmap_cursor *self, rmap_column_set columns,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion_info *info = &self->map->content.portion[self->in_hand];
    rmap_column_set fresh = columns, beside;
    if (self->map->content.piece[info->piece].encoding == RMAP_ENCODING_PLAIN) {
        RMAP_TRY(read_plain(self, info, false, fresh, err));
    } else {
        RMAP_TRY(rmap_cursor_know_header(self, err));
        RMAP_TRY(rmap_cursor_choose_beside(self, info, columns, &beside, err));
        if (beside) {
            RMAP_TRY(read_plain(self, info, true, beside, err));
            self->present |= beside;
        }
        fresh = compact_columns(self, columns & ~beside);
        if (fresh)
            RMAP_TRY(rmap_cursor_read_compact(self, info, fresh, err));
        self->shown.unpredicted = fresh && !beside ? self->portion->unpredicted : NULL;
        fresh |= beside;
    }
    self->portion->first_ray = info->first_ray;
    self->present |= fresh;
    rmap_cursor_show_columns(self->portion, self->present, &self->shown);
    RMAP_TRY(rmap_cursor_check_columns(self, info, fresh, err));
    if (!self->passed_over)
        rmap_map_keep_columns(self->map, self->in_hand, fresh, &self->shown);
out:
    return st;
}

enum rmap_status rmap_cursor_fetch(struct rmap_cursor *self, rmap_column_set columns,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const rmap_column_set cells = RMAP_CELL_COLUMNS;
    columns &= rmap_columns_known(self->shown.timed);
    if (self->map->held) { /* as they were traced: there is nothing to check */
        const struct rmap_portion *held;
        RMAP_TRY(rmap_map_held_portion(self->map, self->in_hand, &held, err));
        rmap_cursor_show_columns(held, columns, &self->shown);
        goto out;
    }
    rmap_column_set before = self->present | self->kept;
    self->kept |=
        rmap_map_borrow_columns(self->map, self->in_hand, columns & ~before, &self->shown);
    rmap_column_set fresh = columns & ~(self->present | self->kept);
    if (fresh)
        RMAP_TRY(read_columns(self, fresh, err));
    rmap_column_set now = self->present | self->kept;
    if ((now & cells) == cells && (before & cells) != cells)
        RMAP_TRY(rmap_cursor_check_cells(self, &self->shown, err));
    if ((now & RMAP_CURVE_CHECK_COLUMNS) == RMAP_CURVE_CHECK_COLUMNS &&
        (before & RMAP_CURVE_CHECK_COLUMNS) != RMAP_CURVE_CHECK_COLUMNS)
        RMAP_TRY(rmap_cursor_check_curve(self, err));
out:
    return st;
}

enum rmap_status rmap_cursor_read(struct rmap_cursor *self, size_t portion,
                                  const struct rmap_portion **portion_ret, struct rmap_error *err)
{
    enum rmap_status st = rmap_cursor_enter(self, portion, portion_ret, err);
    return st == RMAP_OK ? rmap_cursor_fetch(self, self->columns, err) : st;
}
