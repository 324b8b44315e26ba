/* SPDX-License-Identifier: MIT
 *
 * Rays of an older map, taken over block by block.
 */
#include "mpi/trace/trace_reuse.h"

#include <string.h>

#include "base/alloc.h"
#include "io/map/map_cursor.h"

struct rmap_reuse_reader {
    const struct rmap_reuse *reuse;
    struct rmap_cursor *cursor;
    rmap_column_set columns;         /* of the rays that are not touched */
    const struct rmap_portion *rows; /* in hand; NULL: none */
    uint64_t first, end;             /* ids of its rays */
    uint8_t *touched;                /* [its rays] */
    size_t cap_touched, n_touched;
    size_t at[RMAP_TABLE_COUNT]; /* row of the next ray, and of the first of its rows elsewhere */
};

enum rmap_status rmap_reuse_init(struct rmap_reuse *reuse, const struct rmap_map *map,
                                 int32_t space, const struct rmap_scene *scene,
                                 struct rmap_error *err)
{
    const size_t n = rmap_map_n_portion(map);
    *reuse = (struct rmap_reuse){.map = map};
    const enum rmap_status st =
        rmap_touch_init(&reuse->touch, rmap_map_scene_of(map, (size_t)space), scene, err);
    if (st != RMAP_OK || reuse->touch.change.all[0])
        return st;
    reuse->portion = rmap_alloc(n, sizeof *reuse->portion);
    if (!reuse->portion)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the list of portions");
    for (size_t i = 0; i < n; i++)
        if (rmap_map_portion(map, i)->space == space &&
            !rmap_portion_has_gaps(rmap_map_portion(map, i)))
            reuse->portion[reuse->n++] = i;
    return RMAP_OK;
}

void rmap_reuse_fini(struct rmap_reuse *reuse)
{
    rmap_free(reuse->portion);
    rmap_touch_fini(&reuse->touch);
    *reuse = (struct rmap_reuse){.n = 0};
}

static enum rmap_status create(const struct rmap_reuse *reuse, rmap_column_set columns,
                               struct rmap_reuse_reader **reader_ret, struct rmap_error *err)
{
    struct rmap_reuse_reader *reader = rmap_alloc(1, sizeof *reader);
    if (!reader)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a reader");
    reader->reuse = reuse;
    reader->columns = columns;
    const enum rmap_status st =
        rmap_cursor_create(reuse->map, RMAP_TOUCH_PATH_COLUMNS | columns, &reader->cursor, err);
    if (st == RMAP_OK)
        *reader_ret = reader;
    else
        rmap_reuse_reader_destroy(reader);
    return st;
}

enum rmap_status rmap_reuse_reader_create(const struct rmap_reuse *reuse,
                                          struct rmap_reuse_reader **reader_ret,
                                          struct rmap_error *err)
{
    return create(reuse, RMAP_COLUMNS_ALL, reader_ret, err);
}

void rmap_reuse_reader_destroy(struct rmap_reuse_reader *reader)
{
    if (!reader)
        return;
    rmap_cursor_destroy(reader->cursor);
    rmap_free(reader->touched);
    rmap_free(reader);
}

/* The last portion that begins at the ray or before it; n: there is none. */
static size_t find(const struct rmap_reuse *reuse, uint64_t id)
{
    size_t first = 0, end = reuse->n;
    while (first < end) {
        const size_t middle = first + (end - first) / 2;
        if (rmap_map_portion(reuse->map, reuse->portion[middle])->first_ray <= id)
            first = middle + 1;
        else
            end = middle;
    }
    return first > 0 ? first - 1 : reuse->n;
}

static void rewind_rows(struct rmap_reuse_reader *reader)
{
    memset(reader->at, 0, sizeof reader->at);
}

/* Takes a portion in hand: which of its rays must be traced anew, and the columns of the others. */
static enum rmap_status read_portion(struct rmap_reuse_reader *reader, size_t portion,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion_info *info = rmap_map_portion(reader->reuse->map, portion);
    const struct rmap_touch *touch = &reader->reuse->touch;
    const struct rmap_portion *rows;
    reader->rows = NULL;
    RMAP_TRY(RMAP_RESERVE(reader->touched, reader->cap_touched,
                          (size_t)info->n_row[RMAP_TABLE_RAY] + 1, err));
    RMAP_TRY(rmap_cursor_enter(reader->cursor, portion, &rows, err));
    RMAP_TRY(rmap_cursor_fetch(reader->cursor, RMAP_TOUCH_PATH_COLUMNS, err));
    rmap_touch_paths(touch, rows, reader->touched);
    rmap_cursor_pass_over(reader->cursor, reader->touched);
    RMAP_TRY(rmap_cursor_fetch(reader->cursor, reader->columns, err));
    reader->n_touched = rmap_touch_places(touch, rows, reader->touched);
    reader->rows = rows;
    reader->first = info->first_ray;
    reader->end = rmap_portion_end(info);
    rewind_rows(reader);
out:
    return st;
}

/* Takes the portion in hand that has the ray, if one has. */
static enum rmap_status enter(struct rmap_reuse_reader *reader, uint64_t id, struct rmap_error *err)
{
    const struct rmap_reuse *reuse = reader->reuse;
    const size_t k = find(reuse, id);
    if (k == reuse->n || id >= rmap_portion_end(rmap_map_portion(reuse->map, reuse->portion[k])))
        return RMAP_OK;
    return read_portion(reader, reuse->portion[k], err);
}

/* The rows behind those of a ray. */
static void pass(const struct rmap_portion *rows, size_t at[RMAP_TABLE_COUNT])
{
    at[RMAP_TABLE_SEGMENT] += rows->ray.segment_count[at[RMAP_TABLE_RAY]];
    at[RMAP_TABLE_REGISTRATION] += rows->ray.registration_count[at[RMAP_TABLE_RAY]];
    at[RMAP_TABLE_RAY]++;
}

enum rmap_status rmap_reuse_ready(struct rmap_reuse_reader *reader, uint64_t id, uint64_t end,
                                  uint64_t *n_ret, struct rmap_known_way *way_ret,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    *n_ret = 0;
    *way_ret = (struct rmap_known_way){.n = 0};
    if (!reader)
        return RMAP_OK;
    if (!reader->rows || id < reader->first || id >= reader->end)
        RMAP_TRY(enter(reader, id, err));
    if (!reader->rows || id < reader->first || id >= reader->end)
        goto out;
    const size_t row = (size_t)(id - reader->first);
    if (row < reader->at[RMAP_TABLE_RAY])
        rewind_rows(reader);
    while (reader->at[RMAP_TABLE_RAY] < row)
        pass(reader->rows, reader->at);
    while (id + *n_ret < end && id + *n_ret < reader->end &&
           !reader->touched[row + (size_t)*n_ret] &&
           reader->rows->ray.id[row + (size_t)*n_ret] == id + *n_ret)
        (*n_ret)++;
    if (*n_ret == 0 && reader->rows->ray.id[row] == id)
        *way_ret = rmap_touch_known(&reader->reuse->touch, reader->rows, reader->at);
out:
    return st;
}

enum rmap_status rmap_reuse_take(struct rmap_reuse_reader *reader, uint64_t n,
                                 struct rmap_portion_recorder *recorder, struct rmap_tally *tally,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_portion *to = recorder->portion;
    size_t first[RMAP_TABLE_COUNT], count[RMAP_TABLE_COUNT], before[RMAP_TABLE_COUNT];
    memcpy(first, reader->at, sizeof first);
    memcpy(before, to->n_row, sizeof before);
    for (uint64_t i = 0; i < n; i++)
        pass(reader->rows, reader->at);
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        count[t] = reader->at[t] - first[t];
    RMAP_TRY(rmap_portion_append_rows(to, reader->rows, first, count, err));
    rmap_touch_renumber(&reader->reuse->touch, to, before);
    /* Which of the rays that were taken the encoder has to follow. */
    rmap_unpredicted_take(
        &recorder->unpredicted,
        reader->reuse->touch.change.same_sphere ? reader->rows->unpredicted : NULL,
        first[RMAP_TABLE_RAY], reader->at[RMAP_TABLE_RAY], before[RMAP_TABLE_RAY]);
    if (tally)
        RMAP_TRY(rmap_tally_add_rows(tally, to, before, err));
out:
    return st;
}

enum rmap_status rmap_reuse_estimate(const struct rmap_reuse *reuse, double *share_ret,
                                     struct rmap_error *err)
{
    enum { LOOKS = 4, LEAST_STEP = 8 }; /* of thousands of rays each */
    enum rmap_status st = RMAP_OK;
    struct rmap_reuse_reader *reader = NULL;
    double n = 0.0, n_touched = 0.0;
    const size_t even = reuse->n / LOOKS + 1, step = even > LEAST_STEP ? even : LEAST_STEP;
    RMAP_TRY(create(reuse, RMAP_TOUCH_PLACE_COLUMNS, &reader, err));
    for (size_t i = 0; i < reuse->n; i += step) {
        RMAP_TRY(read_portion(reader, reuse->portion[i], err));
        n += (double)reader->rows->n_row[RMAP_TABLE_RAY];
        n_touched += (double)reader->n_touched;
    }
    *share_ret = n > 0.0 ? n_touched / n : 1.0;
out:
    rmap_reuse_reader_destroy(reader);
    return st;
}
