/* SPDX-License-Identifier: MIT
 *
 * The dictionary of a piece being read, checked once and expanded so that rays are copied from it.
 */
#include <string.h>

#include "base/alloc.h"
#include "compact/paths.h"

static enum rmap_status damaged(const char *what, struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_FORMAT, "damaged dictionary of paths: %s", what);
}

/* All of the streams of tables that have rows must be there. */
static enum rmap_status check(const struct rmap_rows *rows, struct rmap_error *err)
{
    if (rows->layout != &rmap_compact_layout)
        return rmap_error_set(err, RMAP_INTERNAL, "rows are not of the compact encoding");
    for (int s = RMAP_STREAM_PATH_source; s <= RMAP_STREAM_PATH_registered; s++)
        if (!rows->data[s] && rows->n_row[rows->layout->stream[s].table] > 0)
            return rmap_error_set(err, RMAP_INTERNAL, "no rows of %s",
                                  rows->layout->stream[s].path);
    if (rows->n_row[RMAP_COMPACT_PATH] > RMAP_PATH_MAX ||
        rows->n_row[RMAP_COMPACT_PATH_SEGMENT] > RMAP_PATH_ROW_MAX ||
        rows->n_row[RMAP_COMPACT_PATH_REGISTRATION] > RMAP_PATH_ROW_MAX)
        return damaged("it is longer than any that is written", err);
    return RMAP_OK;
}

static enum rmap_status fill(const struct rmap_compact_model *model, const struct rmap_rows *rows,
                             struct rmap_path_table *table, struct rmap_error *err)
{
    const int32_t *source = rows->data[RMAP_STREAM_PATH_source];
    const uint8_t *stop = rows->data[RMAP_STREAM_PATH_stop];
    const uint32_t *start_object = rows->data[RMAP_STREAM_PATH_start_object],
                   *n_segment = rows->data[RMAP_STREAM_PATH_segment_count],
                   *n_registration = rows->data[RMAP_STREAM_PATH_registration_count],
                   *object = rows->data[RMAP_STREAM_PATH_object],
                   *event = rows->data[RMAP_STREAM_PATH_event];
    size_t segment = 0, registration = 0;
    for (size_t i = 0; i < table->n; i++) {
        if (n_segment[i] > table->n_segment - segment ||
            n_registration[i] > table->n_registration - registration)
            return damaged("its counts say more rows than there are", err);
        table->path[i] = (struct rmap_known_path){.source = source[i],
                                                  .start_object = (int32_t)(start_object[i] - 1),
                                                  .stop = stop[i],
                                                  .n_segment = n_segment[i],
                                                  .n_registration = n_registration[i],
                                                  .segment = segment,
                                                  .registration = registration};
        table->count[i + 1] = (struct rmap_path_count){n_segment[i], n_registration[i]};
        const struct rmap_folded_path folded = {.source = source[i],
                                                .stop = stop[i],
                                                .n = n_segment[i],
                                                .object = object + segment,
                                                .event = event + segment};
        rmap_path_unfold(model, &folded,
                         &(struct rmap_path_columns){.object = table->object + segment,
                                                     .event = table->event + segment,
                                                     .medium = table->medium + segment});
        segment += n_segment[i];
        registration += n_registration[i];
    }
    if (segment != table->n_segment || registration != table->n_registration)
        return damaged("its counts say fewer rows than there are", err);
    if (registration > 0) {
        memcpy(table->segment, rows->data[RMAP_STREAM_PATH_segment], registration * 4);
        memcpy(table->detector, rows->data[RMAP_STREAM_PATH_detector], registration * 4);
        memcpy(table->registered, rows->data[RMAP_STREAM_PATH_registered], registration);
    }
    return RMAP_OK;
}

/* The paths as rays of a portion. */
static enum rmap_status show_rays(struct rmap_path_table *table, struct rmap_error *err)
{
    struct rmap_portion *rays = &table->rays;
    struct rmap_ray_columns *ray = &rays->ray;
    ray->source = rmap_alloc(table->n + 1, sizeof *ray->source);
    ray->stop = rmap_alloc(table->n + 1, sizeof *ray->stop);
    ray->segment_count = rmap_alloc(table->n + 1, sizeof *ray->segment_count);
    ray->registration_count = rmap_alloc(table->n + 1, sizeof *ray->registration_count);
    table->first_segment = rmap_alloc(table->n + 1, sizeof *table->first_segment);
    table->first_registration = rmap_alloc(table->n + 1, sizeof *table->first_registration);
    if (!table->first_segment || !table->first_registration || !ray->source || !ray->stop ||
        !ray->segment_count || !ray->registration_count)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a dictionary of paths");
    for (size_t i = 0; i < table->n; i++) {
        ray->source[i] = table->path[i].source;
        ray->stop[i] = table->path[i].stop;
        ray->segment_count[i] = table->path[i].n_segment;
        ray->registration_count[i] = table->path[i].n_registration;
        table->first_segment[i] = (uint32_t)table->path[i].segment;
        table->first_registration[i] = (uint32_t)table->path[i].registration;
    }
    rays->segment.object = table->object;
    rays->segment.event = table->event;
    rays->segment.medium = table->medium;
    rays->registration.segment = table->segment;
    rays->registration.detector = table->detector;
    rays->registration.registered = table->registered;
    rays->n_row[RMAP_TABLE_RAY] = table->n;
    rays->n_row[RMAP_TABLE_SEGMENT] = table->n_segment;
    rays->n_row[RMAP_TABLE_REGISTRATION] = table->n_registration;
    return RMAP_OK;
}

const struct rmap_portion *rmap_path_table_rays(const struct rmap_path_table *table)
{
    return &table->rays;
}

const uint32_t *rmap_path_table_first_segments(const struct rmap_path_table *table)
{
    return table->first_segment;
}

const uint32_t *rmap_path_table_first_registrations(const struct rmap_path_table *table)
{
    return table->first_registration;
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
    size_t n = table->n = rows->n_row[RMAP_COMPACT_PATH];
    size_t s = table->n_segment = rows->n_row[RMAP_COMPACT_PATH_SEGMENT];
    size_t r = table->n_registration = rows->n_row[RMAP_COMPACT_PATH_REGISTRATION];
    table->path = rmap_alloc(n + 1, sizeof *table->path);
    table->count = rmap_alloc(n + 1, sizeof *table->count);
    table->object = rmap_alloc(s + 1, sizeof *table->object);
    table->event = rmap_alloc(s + 1, sizeof *table->event);
    table->medium = rmap_alloc(s + 1, sizeof *table->medium);
    table->segment = rmap_alloc(r + 1, sizeof *table->segment);
    table->detector = rmap_alloc(r + 1, sizeof *table->detector);
    table->registered = rmap_alloc(r + 1, sizeof *table->registered);
    if (!table->path || !table->count || !table->object || !table->event || !table->medium ||
        !table->segment || !table->detector || !table->registered)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a dictionary of paths"));
    RMAP_TRY(fill(model, rows, table, err));
    RMAP_TRY(show_rays(table, err));
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
    rmap_free(table->first_segment);
    rmap_free(table->first_registration);
    rmap_free(table->rays.ray.source);
    rmap_free(table->rays.ray.stop);
    rmap_free(table->rays.ray.segment_count);
    rmap_free(table->rays.ray.registration_count);
    rmap_free(table->path);
    rmap_free(table->count);
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
    size_t leg = sizeof *table->object + sizeof *table->event + sizeof *table->medium;
    size_t crossing = sizeof *table->segment + sizeof *table->detector + sizeof *table->registered;
    const struct rmap_ray_columns *ray = &table->rays.ray;
    size_t head = sizeof *ray->source + sizeof *ray->stop + sizeof *ray->segment_count +
                  sizeof *ray->registration_count + sizeof *table->first_segment +
                  sizeof *table->first_registration;
    return sizeof *table + table->n * (sizeof *table->path + sizeof *table->count + head) +
           table->n_segment * leg + table->n_registration * crossing;
}
