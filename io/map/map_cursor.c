/* SPDX-License-Identifier: MIT */
#include <string.h>

#include "base/alloc.h"
#include "io/map/map_cursor_internal.h"
#include "io/scene/scene_limits.h"

enum rmap_status rmap_cursor_create(const struct rmap_map *map, rmap_column_set columns,
                                    struct rmap_cursor **cursor_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_cursor *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a cursor");
    self->map = map;
    self->columns = columns;
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
        rmap_compact_decoder_destroy(self->space[i].decoder);
    }
    for (int s = 0; s < RMAP_STREAM_MAX; s++)
        rmap_free(self->buffer[s].data);
    rmap_cursor_leave_paths(self, SIZE_MAX);
    rmap_portion_destroy(self->own);
    rmap_chunk_reader_destroy(self->reader);
    rmap_free(self->space);
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

enum rmap_status rmap_cursor_check_limits(const struct rmap_cursor *self,
                                          const struct rmap_portion *rows, enum rmap_column column,
                                          const struct rmap_portion_info *info,
                                          struct rmap_error *err)
{
    if (rmap_portion_within(self->map->scene[0], rows, column))
        return RMAP_OK;
    return rmap_error_set(err, RMAP_FORMAT,
                          "%s: %s: a value of the block from ray %llu on names "
                          "nothing in the map's scene",
                          self->map->content.piece[info->piece].name,
                          rmap_column_info(column)->path, (unsigned long long)info->first_ray);
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
    }
    self->portion = *portion;
    rmap_portion_clear(self->portion);
    return RMAP_OK;
}

/* The streams are the columns. */
static enum rmap_status read_plain(struct rmap_cursor *self, const struct rmap_portion_info *info,
                                   rmap_column_set columns, struct rmap_error *err)
{
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
        RMAP_TRY(rmap_chunk_reader_rows(
            self->reader, (size_t)info->piece, c, info->stored_first[table], rows->n_row[table],
            rmap_portion_column(self->portion, (enum rmap_column)c), err));
    }
out:
    return st;
}

/* Counts must add up, or whoever walks the tables walks past their ends. */
static enum rmap_status check_counts(const struct rmap_cursor *self, enum rmap_column column,
                                     enum rmap_table table, struct rmap_error *err)
{
    static const char *const table_name[] = {"/ray", "/segment", "/registration"};
    uint64_t sum = 0;
    const struct rmap_portion *rows = &self->shown;
    const uint32_t *count = rmap_portion_column(rows, column);
    for (size_t i = 0; i < rows->n_row[RMAP_TABLE_RAY]; i++)
        sum += count[i];
    if (sum == rows->n_row[table])
        return RMAP_OK;
    return rmap_error_set(err, RMAP_FORMAT, "%s: the counts of portion %zu do not add up to its %s",
                          self->map->path, self->in_hand, table_name[table]);
}

/* Cells index images. */
static enum rmap_status check_cells(const struct rmap_cursor *self, struct rmap_error *err)
{
    const struct rmap_registration_columns *hit = &self->shown.registration;
    const struct rmap_detector *detector = self->map->scene[0]->detector;
    bool outside = false;
    for (size_t i = 0; i < self->shown.n_row[RMAP_TABLE_REGISTRATION]; i++) {
        const uint32_t *cells = detector[hit->detector[i]].cells;
        outside |= hit->cell[2 * i] >= cells[0] || hit->cell[2 * i + 1] >= cells[1];
    }
    if (!outside)
        return RMAP_OK;
    return rmap_error_set(err, RMAP_FORMAT, "%s: a cell in portion %zu lies outside its detector",
                          self->map->path, self->in_hand);
}

#define CURVE_COLUMNS                                                                              \
    (RMAP_COLUMN_BIT(RMAP_CURVE_ray) | RMAP_COLUMN_BIT(RMAP_CURVE_segment) |                       \
     RMAP_COLUMN_BIT(RMAP_RAY_id) | RMAP_COLUMN_BIT(RMAP_RAY_segment_count))

/* Every point lies on a leg of a ray of the portion, in their order. */
static enum rmap_status check_curve(const struct rmap_cursor *self, struct rmap_error *err)
{
    const struct rmap_portion *rows = &self->shown;
    const size_t n = rows->n_row[RMAP_TABLE_CURVE];
    size_t k = 0;
    for (size_t i = 0; k < n && i < rows->n_row[RMAP_TABLE_RAY]; i++)
        for (uint32_t leg = 0; k < n && rows->curve.ray[k] == rows->ray.id[i]; k++) {
            if (rows->curve.segment[k] < leg ||
                rows->curve.segment[k] >= rows->ray.segment_count[i])
                return rmap_error_set(err, RMAP_FORMAT,
                                      "%s: the points of /curve of ray %llu lie on no leg of it",
                                      self->map->path, (unsigned long long)rows->ray.id[i]);
            leg = rows->curve.segment[k];
        }
    if (k == n)
        return RMAP_OK;
    return rmap_error_set(err, RMAP_FORMAT, "%s: points of /curve in portion %zu are of no ray",
                          self->map->path, self->in_hand);
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
    self->in_hand = portion;
    self->has_own = false;
    rmap_cursor_leave_paths(self, (size_t)info->piece);
    RMAP_TRY(enter_space(self, (size_t)info->space, err));
    /* The piece's chunks vouch for its rows before memory is taken for them. */
    RMAP_TRY(rmap_map_piece_chunks(self->map, (size_t)info->piece, &chunks, err));
    self->portion->first_ray = info->first_ray;
    self->shown = *self->portion;
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        self->shown.n_row[t] = (size_t)info->n_row[t];
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        *rmap_portion_column_address(&self->shown, (enum rmap_column)c) = NULL;
    *portion_ret = &self->shown;
out:
    return st;
}

/* What the columns `fresh`, just read, say of the rows. */
static enum rmap_status check_columns(const struct rmap_cursor *self,
                                      const struct rmap_portion_info *info, rmap_column_set fresh,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (fresh & RMAP_COLUMN_BIT(c))
            RMAP_TRY(rmap_cursor_check_limits(self, &self->shown, (enum rmap_column)c, info, err));
    if (fresh & RMAP_COLUMN_BIT(RMAP_RAY_segment_count))
        RMAP_TRY(check_counts(self, RMAP_RAY_segment_count, RMAP_TABLE_SEGMENT, err));
    if (fresh & RMAP_COLUMN_BIT(RMAP_RAY_registration_count))
        RMAP_TRY(check_counts(self, RMAP_RAY_registration_count, RMAP_TABLE_REGISTRATION, err));
out:
    return st;
}

static void show_columns(struct rmap_cursor *self)
{
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (self->present & RMAP_COLUMN_BIT(c))
            *rmap_portion_column_address(&self->shown, (enum rmap_column)c) =
                rmap_portion_column(self->portion, (enum rmap_column)c);
}

/* What is decoded when columns are asked for: rays are gone through once for all that their paths
 * say, and traced again once. */
static rmap_column_set compact_columns(const struct rmap_cursor *self, rmap_column_set columns)
{
    if (rmap_compact_retraces(columns))
        columns |= self->columns;
    if (columns & RMAP_COLUMNS_DISCRETE)
        columns |= self->columns & RMAP_COLUMNS_DISCRETE;
    return columns & ~self->present;
}

static enum rmap_status read_columns(struct rmap_cursor *self, rmap_column_set columns,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion_info *info = &self->map->content.portion[self->in_hand];
    rmap_column_set fresh = columns;
    if (self->map->content.piece[info->piece].encoding == RMAP_ENCODING_PLAIN) {
        RMAP_TRY(read_plain(self, info, fresh, err));
    } else {
        fresh = compact_columns(self, columns);
        RMAP_TRY(rmap_cursor_read_compact(self, info, fresh, err));
    }
    self->portion->first_ray = info->first_ray;
    self->present |= fresh;
    show_columns(self);
    RMAP_TRY(check_columns(self, info, fresh, err));
    rmap_map_keep_columns(self->map, self->in_hand, fresh, &self->shown);
out:
    return st;
}

enum rmap_status rmap_cursor_fetch(struct rmap_cursor *self, rmap_column_set columns,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const rmap_column_set cells =
        RMAP_COLUMN_BIT(RMAP_REGISTRATION_cell) | RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector);
    rmap_column_set before = self->present | self->kept;
    self->kept |=
        rmap_map_borrow_columns(self->map, self->in_hand, columns & ~before, &self->shown);
    rmap_column_set fresh = columns & ~(self->present | self->kept);
    if (fresh)
        RMAP_TRY(read_columns(self, fresh, err));
    rmap_column_set now = self->present | self->kept;
    if ((now & cells) == cells && (before & cells) != cells)
        RMAP_TRY(check_cells(self, err));
    if ((now & CURVE_COLUMNS) == CURVE_COLUMNS && (before & CURVE_COLUMNS) != CURVE_COLUMNS)
        RMAP_TRY(check_curve(self, err));
out:
    return st;
}

enum rmap_status rmap_cursor_read(struct rmap_cursor *self, size_t portion,
                                  const struct rmap_portion **portion_ret, struct rmap_error *err)
{
    enum rmap_status st = rmap_cursor_enter(self, portion, portion_ret, err);
    return st == RMAP_OK ? rmap_cursor_fetch(self, self->columns, err) : st;
}
