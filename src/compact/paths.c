/* SPDX-License-Identifier: MIT
 *
 * A ray's path as 32-bit words: head (source, stop, start object + 1, segments, registrations),
 * then object + 1 of each segment, 0 and the one expected swapped, then its event xor the one
 * expected, then segment, detector and registered of each registration.
 */
#include <string.h>

#include "base/alloc.h"
#include "compact/damaged.h"
#include "compact/decode_paths.h"
#include "compact/lane.h"
#include "compact/paths.h"
#include "compact/primitives.h"

/* rmap_reserve keeps one capacity per block; those of a table are grown alike. */
#define RESERVE_LIKE(field, own, n)                                                                \
    do {                                                                                           \
        size_t cap = own;                                                                          \
        RMAP_TRY(RMAP_RESERVE(rows->field, cap, n, err));                                          \
    } while (0)

enum rmap_status rmap_path_rows_reserve(struct rmap_path_rows *rows, size_t n, size_t n_segment,
                                        size_t n_registration, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    n += rows->n;
    n_segment += rows->n_segment;
    n_registration += rows->n_registration;
    RESERVE_LIKE(source, rows->cap, n);
    RESERVE_LIKE(stop, rows->cap, n);
    RESERVE_LIKE(start_object, rows->cap, n);
    RESERVE_LIKE(segment_count, rows->cap, n);
    RMAP_TRY(RMAP_RESERVE(rows->registration_count, rows->cap, n, err));
    RESERVE_LIKE(object, rows->cap_segment, n_segment);
    RMAP_TRY(RMAP_RESERVE(rows->event, rows->cap_segment, n_segment, err));
    RESERVE_LIKE(segment, rows->cap_registration, n_registration);
    RESERVE_LIKE(detector, rows->cap_registration, n_registration);
    RMAP_TRY(RMAP_RESERVE(rows->registered, rows->cap_registration, n_registration, err));
out:
    return st;
}

void rmap_path_rows_add(struct rmap_path_rows *rows, const uint32_t *word)
{
    size_t i = rows->n++, n = word[RMAP_WORD_SEGMENTS], m = word[RMAP_WORD_REGISTRATIONS];
    rows->source[i] = (int32_t)word[RMAP_WORD_SOURCE];
    rows->stop[i] = (uint8_t)word[RMAP_WORD_STOP];
    rows->start_object[i] = word[RMAP_WORD_START_OBJECT];
    rows->segment_count[i] = word[RMAP_WORD_SEGMENTS];
    rows->registration_count[i] = word[RMAP_WORD_REGISTRATIONS];
    word += RMAP_WORD_HEAD;
    if (n > 0) {
        memcpy(rows->object + rows->n_segment, word, n * sizeof *word);
        memcpy(rows->event + rows->n_segment, word + n, n * sizeof *word);
    }
    word += 2 * n;
    for (size_t k = 0; k < m; k++) {
        rows->segment[rows->n_registration + k] = word[k];
        rows->detector[rows->n_registration + k] = (int32_t)word[m + k];
        rows->registered[rows->n_registration + k] = (uint8_t)word[2 * m + k];
    }
    rows->n_segment += n;
    rows->n_registration += m;
}

void rmap_path_rows_fini(struct rmap_path_rows *rows)
{
    rmap_free(rows->source);
    rmap_free(rows->stop);
    rmap_free(rows->start_object);
    rmap_free(rows->segment_count);
    rmap_free(rows->registration_count);
    rmap_free(rows->object);
    rmap_free(rows->event);
    rmap_free(rows->segment);
    rmap_free(rows->detector);
    rmap_free(rows->registered);
    *rows = (struct rmap_path_rows){0};
}

/* Objects, events and media of a path from what is stored of it. */

void rmap_path_unfold(const struct rmap_compact_model *model, const struct rmap_folded_path *path,
                      const struct rmap_path_columns *out)
{
    const struct rmap_compact_body *nobody = &model->body[model->n_object], *body = nobody;
    int32_t medium = rmap_first_medium(model, path->source);
    uint32_t before = 0; /* 1 + object */
    for (size_t k = 0; k < path->n; k++) {
        uint32_t now = path->object[k];
        /* a branch that is predicted: the next segments need not wait for this one */
        if ((now == 0 || now == before) && body->inside == medium)
            now = before - now;
        body = now > 0 && now <= model->n_object ? &model->body[now - 1] : nobody;
        uint32_t happened = path->event[k] ^ body->expected;
        if (out->object)
            out->object[k] = (int32_t)(now - 1);
        if (out->event)
            out->event[k] = happened;
        if (out->medium)
            out->medium[k] = (int16_t)medium;
        medium = rmap_medium_after(body, medium, happened);
        before = now;
    }
    rmap_path_end(path, out);
}

/* The dictionary of a piece being read, checked once and expanded so that rays are copied from it.
 */

static enum rmap_status damaged(const char *what, struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_FORMAT, "damaged dictionary of paths: %s", what);
}

/* Whether segments and registrations are there, too. */
static bool are_whole(const struct rmap_rows *rows)
{
    bool all = true;
    for (int s = RMAP_STREAM_PATH_object; s <= RMAP_STREAM_PATH_registered; s++)
        all &= rows->data[s] || rows->n_row[rows->layout->stream[s].table] == 0;
    return all;
}

static enum rmap_status check(const struct rmap_rows *rows, struct rmap_error *err)
{
    if (rows->layout != &rmap_compact_layout)
        return rmap_error_set(err, RMAP_INTERNAL, "rows are not of the compact encoding");
    for (int s = RMAP_STREAM_PATH_source; s < RMAP_STREAM_PATH_object; s++)
        if (!rows->data[s] && rows->n_row[RMAP_COMPACT_PATH] > 0)
            return rmap_error_set(err, RMAP_INTERNAL, "no rows of %s",
                                  rows->layout->stream[s].path);
    if (rows->n_row[RMAP_COMPACT_PATH] > RMAP_PATH_MAX ||
        rows->n_row[RMAP_COMPACT_PATH_SEGMENT] > RMAP_PATH_ROW_MAX ||
        rows->n_row[RMAP_COMPACT_PATH_REGISTRATION] > RMAP_PATH_ROW_MAX)
        return damaged("it is longer than any that is written", err);
    return RMAP_OK;
}

/* What heads say. */
static enum rmap_status fill_heads(const struct rmap_rows *rows, struct rmap_path_table *table,
                                   struct rmap_error *err)
{
    const int32_t *source = rows->data[RMAP_STREAM_PATH_source];
    const uint8_t *stop = rows->data[RMAP_STREAM_PATH_stop];
    const uint32_t *start_object = rows->data[RMAP_STREAM_PATH_start_object],
                   *n_segment = rows->data[RMAP_STREAM_PATH_segment_count],
                   *n_registration = rows->data[RMAP_STREAM_PATH_registration_count];
    const struct rmap_ray_columns *ray = &table->rays.ray;
    size_t segment = 0, registration = 0;
    for (size_t i = 0; i < table->n; i++) {
        if (n_segment[i] > table->n_segment - segment ||
            n_registration[i] > table->n_registration - registration)
            return damaged("its counts say more rows than there are", err);
        table->count[i + 1] = (struct rmap_path_count){n_segment[i], n_registration[i]};
        table->first_segment[i] = (uint32_t)segment;
        table->first_registration[i] = (uint32_t)registration;
        table->start_object[i] = (int32_t)(start_object[i] - 1);
        ray->source[i] = source[i];
        ray->stop[i] = stop[i];
        ray->segment_count[i] = n_segment[i];
        ray->registration_count[i] = n_registration[i];
        segment += n_segment[i];
        registration += n_registration[i];
    }
    if (segment != table->n_segment || registration != table->n_registration)
        return damaged("its counts say fewer rows than there are", err);
    return RMAP_OK;
}

static void fill_rows(const struct rmap_compact_model *model, const struct rmap_rows *rows,
                      struct rmap_path_table *table)
{
    const uint32_t *object = rows->data[RMAP_STREAM_PATH_object],
                   *event = rows->data[RMAP_STREAM_PATH_event];
    const struct rmap_ray_columns *ray = &table->rays.ray;
    for (size_t i = 0; i < table->n; i++) {
        const size_t segment = table->first_segment[i], n = table->count[i + 1].n_segment;
        const struct rmap_folded_path folded = {.source = ray->source[i],
                                                .stop = ray->stop[i],
                                                .n = n,
                                                .object = object + segment,
                                                .event = event + segment};
        rmap_path_unfold(model, &folded,
                         &(struct rmap_path_columns){.object = table->object + segment,
                                                     .event = table->event + segment,
                                                     .medium = table->medium + segment});
        table->n_listed[i + 1] =
            (uint32_t)rmap_primitives_listed(model, table->object + segment, n);
    }
    const size_t n = table->n_registration;
    if (n > 0) {
        memcpy(table->segment, rows->data[RMAP_STREAM_PATH_segment], n * 4);
        memcpy(table->detector, rows->data[RMAP_STREAM_PATH_detector], n * 4);
        memcpy(table->registered, rows->data[RMAP_STREAM_PATH_registered], n);
    }
}

/* Behind the last one comes what stands for numbers that no class has. */
static enum rmap_status list_classes(const struct rmap_compact_model *model,
                                     struct rmap_path_table *table, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_step_classes *classes = &table->classes;
    for (size_t i = 0; i < table->n_segment; i++) {
        const struct rmap_step_class step = {table->object[i], table->event[i], table->medium[i]};
        uint32_t number = rmap_step_class_find(classes, &step);
        if (number == RMAP_NO_STEP_CLASS)
            RMAP_TRY(rmap_step_class_enter(classes, &step, &number, err));
    }
    RMAP_TRY(RMAP_RESERVE(classes->of, classes->cap, classes->n + 1, err));
    classes->of[classes->n] = (struct rmap_step_class){.object = -1};
    table->listed = rmap_alloc_unset(classes->n + 1, sizeof *table->listed);
    if (!table->listed)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a dictionary of paths"));
    for (size_t i = 0; i <= classes->n; i++)
        table->listed[i] = (uint8_t)rmap_primitives_listed(model, &classes->of[i].object, 1);
out:
    return st;
}

const struct rmap_portion *rmap_path_table_rays(const struct rmap_path_table *table)
{
    return &table->rays;
}

const struct rmap_step_classes *rmap_path_table_classes(const struct rmap_path_table *table)
{
    return &table->classes;
}

const uint32_t *rmap_path_table_first_segments(const struct rmap_path_table *table)
{
    return table->first_segment;
}

const uint32_t *rmap_path_table_first_registrations(const struct rmap_path_table *table)
{
    return table->first_registration;
}

/* One more than there are: what takes any path for that of a ray with its own finds one. */
static bool make_heads(struct rmap_path_table *table)
{
    const size_t n = table->n + 1;
    struct rmap_ray_columns *ray = &table->rays.ray;
    table->count = rmap_alloc(n, sizeof *table->count);
    table->n_listed = rmap_alloc(n, sizeof *table->n_listed);
    table->start_object = rmap_alloc(n, sizeof *table->start_object);
    table->first_segment = rmap_alloc(n, sizeof *table->first_segment);
    table->first_registration = rmap_alloc(n, sizeof *table->first_registration);
    ray->source = rmap_alloc(n, sizeof *ray->source);
    ray->stop = rmap_alloc(n, sizeof *ray->stop);
    ray->segment_count = rmap_alloc(n, sizeof *ray->segment_count);
    ray->registration_count = rmap_alloc(n, sizeof *ray->registration_count);
    return table->count && table->n_listed && table->start_object && table->first_segment &&
           table->first_registration && ray->source && ray->stop && ray->segment_count &&
           ray->registration_count;
}

static bool make_rows(struct rmap_path_table *table)
{
    const size_t s = table->n_segment, r = table->n_registration;
    table->object = rmap_alloc_unset(s + 1, sizeof *table->object);
    table->event = rmap_alloc_unset(s + 1, sizeof *table->event);
    table->medium = rmap_alloc_unset(s + 1, sizeof *table->medium);
    table->segment = rmap_alloc_unset(r + 1, sizeof *table->segment);
    table->detector = rmap_alloc_unset(r + 1, sizeof *table->detector);
    table->registered = rmap_alloc_unset(r + 1, sizeof *table->registered);
    return table->object && table->event && table->medium && table->segment && table->detector &&
           table->registered;
}

enum rmap_status rmap_path_table_create(const struct rmap_compact_model *model,
                                        const struct rmap_rows *rows,
                                        struct rmap_path_table **table_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_table *table = NULL;
    RMAP_TRY(check(rows, err));
    table = rmap_alloc(1, sizeof *table);
    if (!table)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a dictionary of paths"));
    struct rmap_portion *rays = &table->rays;
    table->n = rays->n_row[RMAP_TABLE_RAY] = rows->n_row[RMAP_COMPACT_PATH];
    table->n_segment = rays->n_row[RMAP_TABLE_SEGMENT] = rows->n_row[RMAP_COMPACT_PATH_SEGMENT];
    table->n_registration = rays->n_row[RMAP_TABLE_REGISTRATION] =
        rows->n_row[RMAP_COMPACT_PATH_REGISTRATION];
    table->is_whole = are_whole(rows);
    if (!make_heads(table) || (table->is_whole && !make_rows(table)))
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a dictionary of paths"));
    RMAP_TRY(fill_heads(rows, table, err));
    if (table->is_whole) {
        fill_rows(model, rows, table);
        RMAP_TRY(list_classes(model, table, err));
    }
    rays->segment.object = table->object;
    rays->segment.event = table->event;
    rays->segment.medium = table->medium;
    rays->registration.segment = table->segment;
    rays->registration.detector = table->detector;
    rays->registration.registered = table->registered;
    *table_ret = table;
    table = NULL;
out:
    rmap_path_table_destroy(table);
    return st;
}

void rmap_path_table_destroy(struct rmap_path_table *table)
{
    if (!table)
        return;
    rmap_step_classes_fini(&table->classes);
    rmap_free(table->listed);
    rmap_free(table->first_segment);
    rmap_free(table->first_registration);
    rmap_free(table->rays.ray.source);
    rmap_free(table->rays.ray.stop);
    rmap_free(table->rays.ray.segment_count);
    rmap_free(table->rays.ray.registration_count);
    rmap_free(table->start_object);
    rmap_free(table->count);
    rmap_free(table->n_listed);
    rmap_free(table->object);
    rmap_free(table->event);
    rmap_free(table->medium);
    rmap_free(table->segment);
    rmap_free(table->detector);
    rmap_free(table->registered);
    rmap_free(table);
}

size_t rmap_path_table_nbytes(const struct rmap_path_table *table)
{
    size_t segment = sizeof *table->object + sizeof *table->event + sizeof *table->medium;
    size_t crossing = sizeof *table->segment + sizeof *table->detector + sizeof *table->registered;
    const struct rmap_ray_columns *ray = &table->rays.ray;
    size_t head = sizeof *ray->source + sizeof *ray->stop + sizeof *ray->segment_count +
                  sizeof *ray->registration_count + sizeof *table->first_segment +
                  sizeof *table->first_registration;
    const struct rmap_step_classes *classes = &table->classes;
    return sizeof *table + classes->cap * (sizeof *classes->of + sizeof *table->listed) +
           classes->n_slot * sizeof *classes->slot +
           table->n * (sizeof *table->count + sizeof *table->n_listed +
                       sizeof *table->start_object + head) +
           (table->is_whole ? table->n_segment * segment + table->n_registration * crossing : 0);
}

/* A portion by the paths of its rays. */

enum rmap_status rmap_compact_summarise_header(const struct rmap_rows *rows,
                                               struct rmap_compact_summary *summary,
                                               struct rmap_error *err)
{
    struct rmap_lane_header header;
    size_t n_used;
    const enum rmap_status st = rmap_lane_header_read(
        rows->data[RMAP_STREAM_pool64], rows->n_row[RMAP_COMPACT_POOL64], &header, &n_used, err);
    if (st != RMAP_OK)
        return st;
    *summary = (struct rmap_compact_summary){
        .weigh_one = header.mode[RMAP_LANE_RAY_weight] == RMAP_LANE_PREDICTED,
        .ids_run = header.mode[RMAP_LANE_RAY_id] == RMAP_LANE_PREDICTED,
        .media_known = header.mode[RMAP_LANE_SEGMENT_medium] == RMAP_LANE_PREDICTED,
        .placed = header.placed,
        .classed = header.classed,
        .angled = header.angled,
        .measured = header.measured,
        .arrives = header.arrives,
        .n_arrival = header.n_arrival,
        .n_code = header.n_code,
        .first_ray = header.first_ray};
    return RMAP_OK;
}

enum rmap_status
rmap_compact_summarise(const struct rmap_compact_model *model, const struct rmap_path_table *table,
                       const struct rmap_rows *rows, const size_t n_row[RMAP_TABLE_COUNT],
                       struct rmap_compact_summary *summary, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_rows unpacked;
    if (rows->n_row[RMAP_COMPACT_RAY] != n_row[RMAP_TABLE_RAY])
        return rmap_portion_damaged("it has not as many rays as the index says", err);
    RMAP_TRY(rmap_compact_summarise_header(rows, summary, err));
    RMAP_TRY(rmap_step_codes_unpack(rows, summary->n_code, NULL, &unpacked, err));
    const struct rmap_own_paths own = rmap_own_paths(model, table, &unpacked, summary->classed);
    summary->path = own.path;
    summary->n_own = own.n;
    summary->n_own_segment = own.n_segment;
    if (!rows->add_up)
        st = rmap_own_paths_check(&own, n_row, err);
out:
    return st;
}

enum rmap_status rmap_compact_decode_own(const struct rmap_compact_model *model,
                                         const struct rmap_path_table *table,
                                         const struct rmap_rows *rows,
                                         const struct rmap_compact_summary *header,
                                         rmap_column_set wanted, struct rmap_step_buffer *steps,
                                         struct rmap_portion *out, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_rows unpacked;
    RMAP_TRY(rmap_step_codes_unpack(rows, header->n_code, steps, &unpacked, err));
    struct rmap_own_paths own = rmap_own_paths(model, table, &unpacked, header->classed);
    own.path = NULL; /* no other rays are looked at */
    if (own.registration_count)
        RMAP_TRY(rmap_own_paths_check(&own, NULL, err));
    const rmap_column_set columns = (RMAP_COLUMNS_DISCRETE & wanted) |
                                    RMAP_COLUMN_BIT(RMAP_RAY_segment_count) |
                                    RMAP_COLUMN_BIT(RMAP_RAY_id) | RMAP_COLUMN_BIT(RMAP_RAY_weight);
    const size_t n_row[RMAP_TABLE_HISTORY_COUNT] = {own.n, own.n_segment, own.n_registration};
    rmap_portion_clear(out);
    for (int t = 0; t < RMAP_TABLE_HISTORY_COUNT; t++)
        RMAP_TRY(rmap_portion_reserve(out, (enum rmap_table)t, n_row[t], columns, err));
    memcpy(out->n_row, n_row, sizeof n_row);
    rmap_own_paths_unfold(&own, columns, out);
out:
    return st;
}
