/* SPDX-License-Identifier: MIT
 *
 * The discrete columns of a portion from its index.
 */
#include <string.h>

#include "base/alloc.h"
#include "history/history_parts.h"

void rmap_history_row_classes(const struct rmap_history_view *view, uint16_t *row_class)
{
    const struct rmap_history_rows *rows = view->rows;
    const uint8_t member[256] = {[RMAP_HISTORY_RARE] = 1};
    uint16_t class_of[256] = {0};
    uint32_t used = 0;
    for (uint32_t k = 0; k < rows->shape.n_common; k++)
        class_of[k] = view->local_class[k];
    for (size_t i = 0; i < view->n_row[RMAP_TABLE_SEGMENT]; i++)
        row_class[i] = class_of[rows->code[i]];
    if (rows->shape.n_rare == 0)
        return;
    rmap_history_mark_codes(view, member, rows->mark);
    for (size_t w = 0; w * 64 < view->n_row[RMAP_TABLE_SEGMENT]; w++)
        for (uint64_t left = rows->mark[w]; left != 0 && used < rows->shape.n_rare;
             left &= left - 1)
            row_class[w * 64 + (size_t)__builtin_ctzll(left)] =
                view->local_class[rows->rare[used++]];
}

static bool asked(rmap_column_set columns, enum rmap_column column)
{
    return (columns & RMAP_COLUMN_BIT(column)) != 0;
}

static enum rmap_status reserve(const struct rmap_history_view *view, rmap_column_set columns,
                                struct rmap_portion *out, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    rmap_portion_clear(out);
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        RMAP_TRY(rmap_portion_reserve(out, (enum rmap_table)t, view->n_row[t], columns, err));
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        out->n_row[t] = view->n_row[t];
    out->first_ray = view->first_ray;
out:
    return st;
}

/* ---- ROWS ---- */

static void unfold_rays(const struct rmap_history_view *view, rmap_column_set columns,
                        struct rmap_portion *out)
{
    size_t n_ray = view->n_row[RMAP_TABLE_RAY];
    memcpy(out->ray.segment_count, view->segment_count, n_ray * sizeof(uint32_t));
    if (view->registration_count)
        memcpy(out->ray.registration_count, view->registration_count, n_ray * sizeof(uint32_t));
    else
        memset(out->ray.registration_count, 0, n_ray * sizeof(uint32_t));
    for (size_t i = 0; asked(columns, RMAP_RAY_source) && i < n_ray; i++)
        out->ray.source[i] = view->kind_source[view->kind ? view->kind[i] : 0];
    for (size_t i = 0; asked(columns, RMAP_RAY_stop) && i < n_ray; i++)
        out->ray.stop[i] = view->kind_stop[view->kind ? view->kind[i] : 0];
}

static enum rmap_status unfold_legs(const struct rmap_history_view *view, rmap_column_set columns,
                                    struct rmap_portion *out, struct rmap_error *err)
{
    const rmap_column_set legs = RMAP_COLUMN_BIT(RMAP_SEGMENT_object) |
                                 RMAP_COLUMN_BIT(RMAP_SEGMENT_event) |
                                 RMAP_COLUMN_BIT(RMAP_SEGMENT_medium);
    size_t n = view->n_row[RMAP_TABLE_SEGMENT];
    const struct rmap_history_class *what = view->index->class_of;
    if (!(columns & legs))
        return RMAP_OK;
    uint16_t *row_class = rmap_alloc(n, sizeof *row_class);
    if (!row_class)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu rows", n);
    rmap_history_row_classes(view, row_class);
    for (size_t i = 0; asked(columns, RMAP_SEGMENT_object) && i < n; i++)
        out->segment.object[i] = what[row_class[i]].object;
    for (size_t i = 0; asked(columns, RMAP_SEGMENT_event) && i < n; i++)
        out->segment.event[i] = what[row_class[i]].event;
    for (size_t i = 0; asked(columns, RMAP_SEGMENT_medium) && i < n; i++)
        out->segment.medium[i] = (int16_t)what[row_class[i]].medium;
    rmap_free(row_class);
    return RMAP_OK;
}

static void unfold_hits(const struct rmap_history_view *view, rmap_column_set columns,
                        struct rmap_portion *out)
{
    const struct rmap_history_rows *rows = view->rows;
    size_t n = view->n_row[RMAP_TABLE_REGISTRATION];
    for (size_t i = 0; i < n; i++) {
        const struct rmap_history_hit *hit =
            &view->index->hit[rmap_history_number(rows->hit, rows->shape.hit_nbytes, i)];
        if (asked(columns, RMAP_REGISTRATION_detector))
            out->registration.detector[i] = hit->detector;
        if (asked(columns, RMAP_REGISTRATION_registered))
            out->registration.registered[i] = (uint8_t)hit->registered;
        if (asked(columns, RMAP_REGISTRATION_segment))
            out->registration.segment[i] =
                rmap_history_number(rows->leg, rows->shape.leg_nbytes, i);
    }
}

/* ---- PATHS ---- */

static bool paths_add_up(const struct rmap_history_view *view)
{
    const struct rmap_portion *paths = view->index->paths;
    uint64_t n_segment = 0, n_registration = 0;
    for (size_t i = 0; i < view->n_row[RMAP_TABLE_RAY]; i++) {
        size_t path = view->path_row[view->path[i]];
        n_segment += paths->ray.segment_count[path];
        n_registration += paths->ray.registration_count[path];
    }
    return n_segment == view->n_row[RMAP_TABLE_SEGMENT] &&
           n_registration == view->n_row[RMAP_TABLE_REGISTRATION];
}

/* A column of the rows of a ray after those of the other, from the dictionary. */
static void unfold_column(const struct rmap_history_view *view, enum rmap_column column,
                          struct rmap_portion *out)
{
    const struct rmap_history_index *index = view->index;
    const struct rmap_portion *paths = index->paths;
    enum rmap_table table = rmap_column_info(column)->table;
    size_t row = rmap_portion_row_nbytes(paths, column);
    const char *from = rmap_portion_column(paths, column);
    char *to = rmap_portion_column(out, column);
    const uint32_t *first =
        table == RMAP_TABLE_SEGMENT ? index->path_segment : index->path_registration;
    const uint32_t *count =
        table == RMAP_TABLE_SEGMENT ? paths->ray.segment_count : paths->ray.registration_count;
    for (size_t i = 0; i < view->n_row[RMAP_TABLE_RAY]; i++) {
        size_t path = view->path_row[view->path[i]];
        size_t nbytes = row * (table == RMAP_TABLE_RAY ? 1 : count[path]);
        memcpy(to, from + row * (table == RMAP_TABLE_RAY ? path : first[path]), nbytes);
        to += nbytes;
    }
}

static enum rmap_status unfold_paths(const struct rmap_history_view *view, rmap_column_set columns,
                                     struct rmap_portion *out, struct rmap_error *err)
{
    if (!paths_add_up(view))
        return rmap_error_set(
            err, RMAP_FORMAT,
            "the history index is damaged: the rays from id %llu on do not add up",
            (unsigned long long)view->first_ray);
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (asked(columns, (enum rmap_column)c))
            unfold_column(view, (enum rmap_column)c, out);
    return RMAP_OK;
}

enum rmap_status rmap_history_unfold(const struct rmap_history_view *view, rmap_column_set columns,
                                     struct rmap_portion *out, struct rmap_error *err)
{
    columns = (columns & RMAP_HISTORY_DISCRETE) | RMAP_COLUMN_BIT(RMAP_RAY_segment_count) |
              RMAP_COLUMN_BIT(RMAP_RAY_registration_count);
    enum rmap_status st = reserve(view, columns, out, err);
    if (st != RMAP_OK)
        return st;
    if (view->form == RMAP_HISTORY_PATHS)
        return unfold_paths(view, columns, out, err);
    unfold_rays(view, columns, out);
    unfold_hits(view, columns, out);
    return unfold_legs(view, columns, out, err);
}
