/* SPDX-License-Identifier: MIT
 *
 * The discrete columns of a portion from its index.
 */
#include <string.h>

#include "history/history_parts.h"

static bool asked(rmap_column_set columns, enum rmap_column column)
{
    return (columns & RMAP_COLUMN_BIT(column)) != 0;
}

static enum rmap_status reserve(const struct rmap_history_view *view, rmap_column_set columns,
                                struct rmap_portion *out, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    rmap_portion_clear(out);
    for (int t = 0; t < RMAP_TABLE_HISTORY_COUNT; t++)
        RMAP_TRY(rmap_portion_reserve(out, (enum rmap_table)t, view->n_row[t], columns, err));
    for (int t = 0; t < RMAP_TABLE_HISTORY_COUNT; t++)
        out->n_row[t] = view->n_row[t];
    out->first_ray = view->first_ray;
out:
    return st;
}

static enum rmap_status does_not_add_up(const struct rmap_history_view *view,
                                        struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_FORMAT,
                          "the history index is damaged: the rays from id %llu on do not add up",
                          (unsigned long long)view->first_ray);
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

static void unfold_rare_legs(const struct rmap_history_view *view, rmap_column_set columns,
                             struct rmap_portion *out)
{
    const uint64_t *rare = rmap_history_rare_legs(view);
    const struct rmap_history_class *what = view->index->class_of;
    for (size_t w = 0; rare && w * 64 < view->n_row[RMAP_TABLE_SEGMENT]; w++)
        for (uint64_t left = rare[w]; left != 0; left &= left - 1) {
            size_t leg = w * 64 + (size_t)__builtin_ctzll(left);
            const struct rmap_history_class *is =
                &what[view->local_class[rmap_history_rare_at(view, rare, leg)]];
            if (asked(columns, RMAP_SEGMENT_object))
                out->segment.object[leg] = is->object;
            if (asked(columns, RMAP_SEGMENT_event))
                out->segment.event[leg] = is->event;
            if (asked(columns, RMAP_SEGMENT_medium))
                out->segment.medium[leg] = (int16_t)is->medium;
        }
}

/* What the classes with codes are, then each leg's, then the rare ones. */
static void unfold_legs(const struct rmap_history_view *view, rmap_column_set columns,
                        struct rmap_portion *out)
{
    const uint8_t *code = view->rows->code;
    const struct rmap_history_class *what = view->index->class_of;
    bool object = asked(columns, RMAP_SEGMENT_object), event = asked(columns, RMAP_SEGMENT_event);
    bool medium = asked(columns, RMAP_SEGMENT_medium);
    struct {
        int32_t object[256];
        uint32_t event[256];
        int16_t medium[256];
    } of = {{0}, {0}, {0}};
    size_t n = view->n_row[RMAP_TABLE_SEGMENT];
    if (!object && !event && !medium)
        return;
    for (uint32_t k = 0; k < view->rows->shape.n_common; k++) {
        of.object[k] = what[view->local_class[k]].object;
        of.event[k] = what[view->local_class[k]].event;
        of.medium[k] = (int16_t)what[view->local_class[k]].medium;
    }
    for (size_t i = 0; object && i < n; i++)
        out->segment.object[i] = of.object[code[i]];
    for (size_t i = 0; event && i < n; i++)
        out->segment.event[i] = of.event[code[i]];
    for (size_t i = 0; medium && i < n; i++)
        out->segment.medium[i] = of.medium[code[i]];
    unfold_rare_legs(view, columns, out);
}

static bool unfold_hits(const struct rmap_history_view *view, rmap_column_set columns,
                        struct rmap_portion *out)
{
    const struct rmap_history_rows *rows = view->rows;
    const struct rmap_history_hit *what = view->index->hit;
    unsigned nbytes = rows->shape.hit_nbytes;
    size_t n = view->n_row[RMAP_TABLE_REGISTRATION];
    for (size_t i = 0; asked(columns, RMAP_REGISTRATION_detector) && i < n; i++)
        out->registration.detector[i] = what[rmap_history_number(rows->hit, nbytes, i)].detector;
    for (size_t i = 0; asked(columns, RMAP_REGISTRATION_registered) && i < n; i++)
        out->registration.registered[i] =
            (uint8_t)what[rmap_history_number(rows->hit, nbytes, i)].registered;
    return !asked(columns, RMAP_REGISTRATION_segment) ||
           rmap_history_widen(rows->leg, n, rows->far, rows->shape.n_far,
                              out->registration.segment);
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
        return does_not_add_up(view, err);
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (asked(columns, (enum rmap_column)c))
            unfold_column(view, (enum rmap_column)c, out);
    return RMAP_OK;
}

enum rmap_status rmap_history_unfold(const struct rmap_history_view *view, rmap_column_set columns,
                                     struct rmap_portion *out, struct rmap_error *err)
{
    columns = (columns & RMAP_COLUMNS_DISCRETE) | RMAP_COLUMN_BIT(RMAP_RAY_segment_count) |
              RMAP_COLUMN_BIT(RMAP_RAY_registration_count);
    enum rmap_status st = reserve(view, columns, out, err);
    if (st != RMAP_OK)
        return st;
    if (view->form == RMAP_HISTORY_PATHS)
        return unfold_paths(view, columns, out, err);
    unfold_rays(view, columns, out);
    unfold_legs(view, columns, out);
    return unfold_hits(view, columns, out) ? RMAP_OK : does_not_add_up(view, err);
}
