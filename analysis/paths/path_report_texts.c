/* SPDX-License-Identifier: MIT
 *
 * Sequences and criteria of classes of paths, each from its first ray.
 */
#include "analysis/paths/path_report_texts.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/paths/path_text.h"
#include "base/alloc.h"
#include "io/map/map_cursor.h"

/* One thread's way through the map, ray after ray. */
struct reading {
    const struct rmap_path_report *report;
    struct rmap_cursor *cursor;
    struct rmap_overlay_view *view; /* NULL: no receivers */
    const struct rmap_portion *portion;
    size_t in_hand; /* SIZE_MAX: none */
    rmap_path_step *symbol;
    size_t symbol_cap;
};

/* Row of the ray in the portion in hand. */
static bool find_row(const struct rmap_portion *portion, uint64_t ray,
                     struct rmap_path_place_of_ray *place)
{
    *place = (struct rmap_path_place_of_ray){0};
    for (; place->ray < portion->n_row[RMAP_TABLE_RAY]; place->ray++) {
        if (portion->ray.id[place->ray] == ray)
            return true;
        place->segment += portion->ray.segment_count[place->ray];
        place->registration += portion->ray.registration_count[place->ray];
    }
    return false;
}

static enum rmap_status read_portion(struct reading *reading, size_t index, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *stored = NULL;
    const size_t space = (size_t)rmap_map_portion(reading->report->map, index)->space;
    RMAP_TRY(rmap_cursor_read(reading->cursor, index, &stored, err));
    reading->portion = stored;
    if (reading->view)
        RMAP_TRY(rmap_overlay_view_extend(reading->view, stored, space, &reading->portion, err));
    reading->in_hand = index;
out:
    return st;
}

static enum rmap_status find_ray(struct reading *reading, uint64_t ray,
                                 struct rmap_path_place_of_ray *place, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_map *map = reading->report->map;
    size_t index = rmap_map_n_portion(map);
    while (rmap_map_find_ray(map, ray, &index)) {
        if (index != reading->in_hand)
            RMAP_TRY(read_portion(reading, index, err));
        if (find_row(reading->portion, ray, place))
            goto out;
    }
    st = rmap_error_set(err, RMAP_INTERNAL, "ray %" PRIu64 " is not where it was", ray);
out:
    return st;
}

/* The criterion with the one that the rays were picked by. */
static enum rmap_status narrow(const char *where, char **criterion, struct rmap_error *err)
{
    if (!where || !*criterion)
        return RMAP_OK;
    const size_t nbytes = strlen(where) + strlen(*criterion) + sizeof "() and ";
    char *text = rmap_alloc(nbytes, 1);
    if (!text)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a criterion");
    (void)snprintf(text, nbytes, "(%s) and %s", where, *criterion);
    rmap_free(*criterion);
    *criterion = text;
    return RMAP_OK;
}

static enum rmap_status write_texts(const struct rmap_path_report *report,
                                    struct rmap_path_row *row, const rmap_path_step *step, size_t n,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(rmap_path_key_text(report->keys, step, n, 0, &row->sequence, err));
    RMAP_TRY(rmap_path_criterion_of(report->keys, row->source, step, n,
                                    row->rays == 1 ? row->first_ray : RMAP_PATH_MANY_RAYS,
                                    &row->criterion, err));
    st = narrow(report->criterion, &row->criterion, err);
out:
    return st;
}

/* Where the map is read; made when first needed. */
static enum rmap_status open_map(struct reading *reading, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_report *report = reading->report;
    rmap_column_set columns = rmap_path_keys_columns(report->keys);
    if (reading->cursor)
        return RMAP_OK;
    if (report->overlay) {
        columns = rmap_overlay_columns(report->overlay, columns);
        RMAP_TRY(rmap_overlay_view_create(report->overlay, &reading->view, err));
    }
    st = rmap_cursor_create(report->map, columns, &reading->cursor, err);
out:
    return st;
}

/* Which of the ray's paths is that of the class. */
static void find_path(const struct reading *reading, const struct rmap_path_row *row,
                      struct rmap_path_place_of_ray *place, size_t *n)
{
    const struct rmap_path_keys *keys = reading->report->keys;
    const struct rmap_portion *portion = reading->portion;
    const size_t end = place->registration + portion->ray.registration_count[place->ray];
    const struct rmap_path_view *view = &reading->report->view;
    if (!view->until_detector) {
        (void)rmap_path_key_of(keys, portion, place, reading->symbol, n);
        return;
    }
    for (size_t i = place->registration; i < end; i++) {
        place->until = i + 1;
        if (!portion->registration.registered[i] ||
            portion->registration.detector[i] != view->detector ||
            !rmap_path_key_of(keys, portion, place, reading->symbol, n))
            continue;
        if (rmap_keys_equal(rmap_path_key_hash(reading->symbol, *n, row->source), row->key))
            return;
    }
}

static enum rmap_status read_texts(struct reading *reading, struct rmap_path_row *row,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_place_of_ray place;
    size_t n = 0;
    RMAP_TRY(open_map(reading, err));
    RMAP_TRY(find_ray(reading, row->first_ray, &place, err));
    RMAP_TRY(RMAP_RESERVE(reading->symbol, reading->symbol_cap,
                          (size_t)reading->portion->ray.segment_count[place.ray] +
                              reading->portion->ray.registration_count[place.ray] + 1,
                          err));
    find_path(reading, row, &place, &n);
    st = write_texts(reading->report, row, reading->symbol, n, err);
out:
    return st;
}

static int compare_rows(const void *a_, const void *b_)
{
    const struct rmap_path_row *const *a = a_, *const *b = b_;
    return ((*a)->first_ray > (*b)->first_ray) - ((*a)->first_ray < (*b)->first_ray);
}

enum rmap_status rmap_path_report_add_texts(struct rmap_path_report *report, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct reading reading = {.report = report, .in_hand = SIZE_MAX};
    struct rmap_path_row **row = rmap_alloc(report->n_row + 1, sizeof *row);
    if (!row)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu paths", report->n_row);
    for (size_t k = 0; k < report->n_row; k++)
        row[k] = &report->row[k];
    qsort(row, report->n_row, sizeof(struct rmap_path_row *), compare_rows);
    for (size_t k = 0; k < report->n_row; k++)
        RMAP_TRY(read_texts(&reading, row[k], err));
out:
    rmap_overlay_view_destroy(reading.view);
    rmap_cursor_destroy(reading.cursor);
    rmap_free(reading.symbol);
    rmap_free(row);
    return st;
}
