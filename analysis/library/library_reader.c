/* SPDX-License-Identifier: MIT
 *
 * Columns of the rays of a block that match, as a fold hands them over.
 */
#include <string.h>

#include "analysis/library/library_map.h"
#include "analysis/query/fold.h"
#include "analysis/report/ray_report.h"
#include "analysis/report/ray_table.h"
#include "base/alloc.h"

/* Rows of a column: the portion's own, or a copy. */
struct column {
    size_t row_nbytes;
    const void *data;
    char *copy; /* [cap] */
    size_t cap;
};

struct raymap_reader {
    const struct rmap_map *map;
    struct rmap_criterion *criterion; /* NULL: all rays */
    struct rmap_ray_table *table;
    struct rmap_fold fold;
    struct rmap_fold_scanner *scanner;
    struct column *column;           /* [table->n] */
    bool has_rows[RMAP_TABLE_COUNT]; /* tables that a column was asked of */
    bool has_block;
    uint64_t n_row[RMAP_TABLE_COUNT]; /* of the block, of rays that match */
};

/* The rows of all tables that a ray has. */
struct span {
    size_t first[RMAP_TABLE_COUNT], n[RMAP_TABLE_COUNT];
};

/* Of the ray in a row, from that of the ray before it; zeroed: before the first. */
static void next_span(const struct rmap_portion *portion, size_t row, struct span *at)
{
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        at->first[t] += at->n[t];
    at->n[RMAP_TABLE_RAY] = 1;
    if (portion->ray.segment_count)
        at->n[RMAP_TABLE_SEGMENT] = portion->ray.segment_count[row];
    if (portion->ray.registration_count)
        at->n[RMAP_TABLE_REGISTRATION] = portion->ray.registration_count[row];
    if (portion->curve.ray)
        at->n[RMAP_TABLE_CURVE] =
            rmap_portion_curve_of(portion, portion->ray.id[row], &at->first[RMAP_TABLE_CURVE]);
}

/* Whether the portion's rows of a column are just those. */
static bool is_stored(const struct rmap_table_column *column)
{
    return !column->quantity && rmap_column_info(column->column)->table == column->table;
}

static enum rmap_status make_room(struct raymap_reader *self, const struct rmap_matched *rays,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t c = 0; c < self->table->n; c++) {
        const struct rmap_table_column *from = &self->table->column[c];
        struct column *column = &self->column[c];
        const size_t width =
            from->width > 0 ? (size_t)from->width : (size_t)rays->portion->n_channel;
        column->row_nbytes = width * rmap_element_nbytes(from->element);
        if (!rays->match && is_stored(from)) {
            const void *stored = rmap_portion_column(rays->portion, from->column);
            column->data = stored ? stored : "";
            continue;
        }
        const size_t n = (size_t)self->n_row[from->table];
        RMAP_TRY(RMAP_RESERVE(column->copy, column->cap, n * column->row_nbytes + 1, err));
        column->data = column->copy;
    }
out:
    return st;
}

/* Rows of one ray of all columns that are copied, behind those `done`. */
static enum rmap_status copy_ray(struct raymap_reader *self, const struct rmap_matched *rays,
                                 size_t row, const struct span *at, const uint64_t *done,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_ray_report *report = NULL;
    const struct rmap_table_ray ray = {rays->portion, rays->space, row,
                                       at->first[RMAP_TABLE_SEGMENT],
                                       at->first[RMAP_TABLE_REGISTRATION]};
    if (self->table->is_reported)
        RMAP_TRY(rmap_ray_report_row(self->map, ray.space, ray.portion, ray.row, ray.segment,
                                     ray.registration, &report, err));
    for (size_t c = 0; c < self->table->n; c++) {
        const struct rmap_table_column *from = &self->table->column[c];
        const struct column *column = &self->column[c];
        if (column->data != column->copy)
            continue;
        char *to = column->copy + done[from->table] * column->row_nbytes;
        if (is_stored(from)) {
            const char *stored = rmap_portion_column(rays->portion, from->column);
            memcpy(to, stored + at->first[from->table] * column->row_nbytes,
                   at->n[from->table] * column->row_nbytes);
            continue;
        }
        for (size_t k = 0; k < at->n[from->table]; k++)
            rmap_ray_table_read(self->table, from, &ray, report, k, to + k * column->row_nbytes);
    }
out:
    rmap_ray_report_destroy(report);
    return st;
}

static void count_rows(struct raymap_reader *self, const struct rmap_matched *rays)
{
    struct span at = {0};
    const size_t n = rays->portion->n_row[RMAP_TABLE_RAY];
    if (!rays->match)
        for (int t = 0; t < RMAP_TABLE_COUNT; t++)
            self->n_row[t] = rays->portion->n_row[t];
    for (size_t row = 0; rays->match && row < n; row++) {
        next_span(rays->portion, row, &at);
        for (int t = 0; rays->match[row] && t < RMAP_TABLE_COUNT; t++)
            self->n_row[t] += at.n[t];
    }
}

static enum rmap_status add(void *state, const struct rmap_matched *rays, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct raymap_reader *self = state;
    struct span at = {0};
    uint64_t done[RMAP_TABLE_COUNT] = {0};
    bool is_whole = !rays->match;
    count_rows(self, rays);
    RMAP_TRY(make_room(self, rays, err));
    for (size_t c = 0; c < self->table->n; c++)
        is_whole = is_whole && self->column[c].data != self->column[c].copy;
    const size_t n = is_whole ? 0 : rays->portion->n_row[RMAP_TABLE_RAY];
    for (size_t row = 0; row < n; row++) {
        next_span(rays->portion, row, &at);
        if (rays->match && !rays->match[row])
            continue;
        RMAP_TRY(copy_ray(self, rays, row, &at, done, err));
        for (int t = 0; t < RMAP_TABLE_COUNT; t++)
            done[t] += at.n[t];
    }
out:
    return st;
}

/* One thread adds to one state, which is never merged. */
static const struct rmap_fold_kind reading = {.add = add};

enum raymap_status raymap_reader_create(const raymap_map *map, const char *criterion,
                                        const char *columns, raymap_reader **reader_ret,
                                        struct raymap_error *error)
{
    struct rmap_library_call call = rmap_library_enter();
    enum rmap_status st = RMAP_OK;
    struct raymap_reader *self = rmap_alloc(1, sizeof *self);
    if (!self)
        RMAP_TRY(rmap_error_set(&call.error, RMAP_SYSTEM, "out of memory for a reader"));
    self->map = map->map;
    if (criterion)
        RMAP_TRY(rmap_library_criterion(map->map, criterion, &self->criterion, &call.error));
    RMAP_TRY(
        rmap_ray_table_create(map->map, columns, RMAP_VECTORS_WHOLE, &self->table, &call.error));
    self->has_rows[RMAP_TABLE_RAY] = true;
    for (size_t c = 0; c < self->table->n; c++)
        self->has_rows[self->table->column[c].table] = true;
    self->column = rmap_alloc(self->table->n, sizeof *self->column);
    if (!self->column)
        RMAP_TRY(rmap_error_set(&call.error, RMAP_SYSTEM, "out of memory for columns"));
    self->fold = (struct rmap_fold){.kind = &reading,
                                    .context = self,
                                    .map = map->map,
                                    .criterion = self->criterion,
                                    .columns = self->table->columns};
    if (self->fold.columns & RMAP_COLUMNS_CURVE)
        self->fold.columns |= RMAP_COLUMN_BIT(RMAP_RAY_id) | RMAP_COLUMN_BIT(RMAP_CURVE_ray);
    RMAP_TRY(rmap_fold_scanner_create(&self->fold, &self->scanner, &call.error));
    *reader_ret = self;
    self = NULL;
out:
    raymap_reader_destroy(self);
    return rmap_library_leave(&call, st, error);
}

void raymap_reader_destroy(raymap_reader *self)
{
    if (!self)
        return;
    rmap_fold_scanner_destroy(self->scanner);
    for (size_t c = 0; self->column && c < self->table->n; c++)
        rmap_free(self->column[c].copy);
    rmap_free(self->column);
    rmap_ray_table_destroy(self->table);
    rmap_criterion_destroy(self->criterion);
    rmap_free(self);
}

enum raymap_status raymap_reader_column(const raymap_reader *self, size_t c,
                                        struct raymap_column *column_ret)
{
    _Static_assert((int)RAYMAP_F64 == (int)RMAP_F64 && (int)RAYMAP_I16 == (int)RMAP_I16,
                   "types are the map's");
    if (c >= self->table->n)
        return RAYMAP_USAGE;
    const struct rmap_table_column *column = &self->table->column[c];
    *column_ret = (struct raymap_column){.name = column->name,
                                         .unit = column->unit,
                                         .description = column->description,
                                         .table = (int32_t)column->table,
                                         .type = (int32_t)column->element,
                                         .width = column->width};
    return RAYMAP_OK;
}

enum raymap_status raymap_read(raymap_reader *self, size_t block, struct raymap_block *block_ret,
                               struct raymap_error *error)
{
    struct rmap_library_call call = rmap_library_enter();
    enum rmap_status st = RMAP_OK;
    self->has_block = false;
    memset(self->n_row, 0, sizeof self->n_row);
    if (block >= rmap_map_n_portion(self->map))
        RMAP_TRY(rmap_error_set(&call.error, RMAP_USAGE, "no block %zu: the map has %zu", block,
                                rmap_map_n_portion(self->map)));
    /* Where nothing matches, nothing is added. */
    for (size_t c = 0; c < self->table->n; c++)
        self->column[c].data = "";
    RMAP_TRY(rmap_fold_scanner_add(self->scanner, self, block, block + 1, &call.error));
    self->has_block = true;
    if (block_ret) {
        const struct rmap_portion_info *info = rmap_map_portion(self->map, block);
        *block_ret = (struct raymap_block){.first_ray = info->first_ray,
                                           .rays = info->n_row[RMAP_TABLE_RAY],
                                           .space = info->space};
        for (int t = 0; t < RMAP_TABLE_COUNT; t++)
            block_ret->rows[t] = self->has_rows[t] ? self->n_row[t] : 0;
    }
out:
    return rmap_library_leave(&call, st, error);
}

const void *raymap_data(const raymap_reader *self, size_t c)
{
    return self->has_block && c < self->table->n ? self->column[c].data : NULL;
}
