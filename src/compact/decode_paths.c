/* SPDX-License-Identifier: MIT */
#include "compact/decode_paths.h"

#include <string.h>

#define BIT(column) RMAP_COLUMN_BIT(column)

static enum rmap_status damaged(const char *what, struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_FORMAT, "damaged portion: %s", what);
}

struct rmap_own_paths rmap_own_paths(const struct rmap_compact_model *model,
                                     const struct rmap_rows *rows)
{
    void *const *data = rows->data;
    const uint32_t *object = data[RMAP_STREAM_OWN_object];
    size_t n_segment = rows->n_row[RMAP_COMPACT_OWN_SEGMENT];
    return (struct rmap_own_paths){.model = model,
                                   .n = rows->n_row[RMAP_COMPACT_OWN],
                                   .n_registration = rows->n_row[RMAP_COMPACT_OWN_REGISTRATION],
                                   .n_segment = n_segment,
                                   .guided = object && rmap_path_guided(model, object, n_segment),
                                   .path = data[RMAP_STREAM_ray_path],
                                   .source = data[RMAP_STREAM_OWN_source],
                                   .stop = data[RMAP_STREAM_OWN_stop],
                                   .start_object = data[RMAP_STREAM_OWN_start_object],
                                   .segment_count = data[RMAP_STREAM_OWN_segment_count],
                                   .registration_count = data[RMAP_STREAM_OWN_registration_count],
                                   .object = object,
                                   .event = data[RMAP_STREAM_OWN_event],
                                   .segment = data[RMAP_STREAM_OWN_segment],
                                   .detector = data[RMAP_STREAM_OWN_detector],
                                   .registered = data[RMAP_STREAM_OWN_registered]};
}

/* At most 2^32 rays of 2^32
 * rows: no sum is too large. */
enum rmap_status rmap_own_paths_check(const struct rmap_own_paths *own,
                                      const struct rmap_path_table *table,
                                      const size_t n_row[RMAP_TABLE_COUNT], struct rmap_error *err)
{
    size_t n_mine = 0;
    uint64_t n[2] = {0, 0}, own_n[2] = {0, 0};
    for (size_t i = 0; i < n_row[RMAP_TABLE_RAY]; i++) {
        uint32_t path = own->path[i];
        if (path > table->n)
            return damaged("a ray refers to a path that is not there", err);
        n[0] += table->count[path].n_segment; /* 0 for path 0 */
        n[1] += table->count[path].n_registration;
        n_mine += path == 0;
    }
    for (size_t k = 0; k < own->n; k++) {
        own_n[0] += own->segment_count[k];
        own_n[1] += own->registration_count[k];
    }
    if (n_mine != own->n || own_n[0] != own->n_segment || own_n[1] != own->n_registration)
        return damaged("its own paths have not as many rows as there are", err);
    if (n[0] + own_n[0] != n_row[RMAP_TABLE_SEGMENT] ||
        n[1] + own_n[1] != n_row[RMAP_TABLE_REGISTRATION])
        return damaged("its paths have not as many rows as the index says", err);
    return RMAP_OK;
}

/* Sources, stops, counts. */
static void fill_heads(const struct rmap_path_table *table, const struct rmap_own_paths *own,
                       rmap_column_set columns, struct rmap_portion *out)
{
    size_t k = 0;
    const struct rmap_ray_columns *ray = &out->ray;
    for (size_t i = 0; i < out->n_row[RMAP_TABLE_RAY]; i++) {
        struct rmap_known_path path;
        if (own->path[i] > 0) {
            path = table->path[own->path[i] - 1];
        } else {
            path = (struct rmap_known_path){.source = own->source[k],
                                            .stop = own->stop[k],
                                            .start_object = (int32_t)(own->start_object[k] - 1),
                                            .n_segment = own->segment_count[k],
                                            .n_registration = own->registration_count[k]};
            k++;
        }
        if (columns & BIT(RMAP_RAY_source))
            ray->source[i] = path.source;
        if (columns & BIT(RMAP_RAY_stop))
            ray->stop[i] = path.stop;
        if (columns & BIT(RMAP_RAY_start_object))
            ray->start_object[i] = path.start_object;
        if (columns & BIT(RMAP_RAY_segment_count))
            ray->segment_count[i] = path.n_segment;
        if (columns & BIT(RMAP_RAY_registration_count))
            ray->registration_count[i] = path.n_registration;
    }
}

static void fill_own_legs(const struct rmap_own_paths *own, size_t k, size_t from, size_t to,
                          rmap_column_set columns, struct rmap_portion *out)
{
    struct rmap_segment_columns *segment = &out->segment;
    const struct rmap_folded_path path = {.source = own->source[k],
                                          .stop = own->stop[k],
                                          .guided = own->guided,
                                          .n = own->segment_count[k],
                                          .n_stored = own->n_segment - from,
                                          .object = own->object + from,
                                          .event = own->event + from};
    const struct rmap_path_columns legs = {
        .n_row = out->n_row[RMAP_TABLE_SEGMENT] - to,
        .object = columns & BIT(RMAP_SEGMENT_object) ? segment->object + to : NULL,
        .event = columns & BIT(RMAP_SEGMENT_event) ? segment->event + to : NULL,
        .medium = columns & BIT(RMAP_SEGMENT_medium) ? segment->medium + to : NULL};
    rmap_path_unfold(own->model, &path, &legs);
}

/* Known paths are copied by so many legs, into rows that are filled later, if there are as many:
 * own paths come after them. */
#define COPIED 8

static inline void copy_legs(void *to, const void *from, size_t n, size_t nbytes)
{
    uint8_t *out = to;
    const uint8_t *in = from;
    if (n % COPIED != 0)
        memcpy(out, in, n * nbytes);
    for (size_t i = 0; n % COPIED == 0 && i < n; i += COPIED)
        memcpy(out + i * nbytes, in + i * nbytes, COPIED * nbytes);
}

/* Objects, events, and media as the paths say. */
static void fill_legs(const struct rmap_path_table *table, const struct rmap_own_paths *own,
                      rmap_column_set columns, struct rmap_portion *out)
{
    struct rmap_segment_columns *segment = &out->segment;
    size_t k = 0, from = 0, to = 0, n_row = out->n_row[RMAP_TABLE_SEGMENT];
    for (size_t i = 0; i < out->n_row[RMAP_TABLE_RAY]; i++) {
        if (own->path[i] == 0) {
            fill_own_legs(own, k, from, to, columns, out);
            from += own->segment_count[k];
            to += own->segment_count[k++];
            continue;
        }
        const struct rmap_known_path *path = &table->path[own->path[i] - 1];
        size_t n = path->n_segment, most = (n + COPIED - 1) / COPIED * COPIED;
        most = most <= n_row - to && most <= table->n_segment - path->segment ? most : n;
        if (columns & BIT(RMAP_SEGMENT_object))
            copy_legs(segment->object + to, table->object + path->segment, most, 4);
        if (columns & BIT(RMAP_SEGMENT_event))
            copy_legs(segment->event + to, table->event + path->segment, most, 4);
        if (columns & BIT(RMAP_SEGMENT_medium))
            copy_legs(segment->medium + to, table->medium + path->segment, most, 2);
        to += n;
    }
}

/* Rows [from, from + n) of a path, out of its own columns or the table's. */
struct crossings {
    const uint32_t *segment;
    const int32_t *detector;
    const uint8_t *registered;
};

static void fill_crossings(const struct rmap_path_table *table, const struct rmap_own_paths *own,
                           rmap_column_set columns, struct rmap_portion *out)
{
    const struct crossings known = {table->segment, table->detector, table->registered},
                           rare = {own->segment, own->detector, own->registered};
    struct rmap_registration_columns *registration = &out->registration;
    size_t k = 0, own_from = 0, to = 0;
    for (size_t i = 0; i < out->n_row[RMAP_TABLE_RAY]; i++) {
        const struct crossings *c = &rare;
        size_t from = own_from, n;
        if (own->path[i] > 0) {
            c = &known;
            from = table->path[own->path[i] - 1].registration;
            n = table->path[own->path[i] - 1].n_registration;
        } else {
            n = own->registration_count[k++];
            own_from += n;
        }
        for (size_t j = 0; j < n; j++, to++) {
            if (columns & BIT(RMAP_REGISTRATION_segment))
                registration->segment[to] = c->segment[from + j];
            if (columns & BIT(RMAP_REGISTRATION_detector))
                registration->detector[to] = c->detector[from + j];
            if (columns & BIT(RMAP_REGISTRATION_registered))
                registration->registered[to] = c->registered[from + j];
        }
    }
}

void rmap_paths_fill(const struct rmap_own_paths *own, const struct rmap_path_table *table,
                     rmap_column_set columns, struct rmap_portion *out)
{
    if (columns & RMAP_HEAD_COLUMNS)
        fill_heads(table, own, columns, out);
    if (columns & (BIT(RMAP_SEGMENT_object) | BIT(RMAP_SEGMENT_event)))
        fill_legs(table, own, columns, out);
    if (columns & (BIT(RMAP_REGISTRATION_segment) | BIT(RMAP_REGISTRATION_detector) |
                   BIT(RMAP_REGISTRATION_registered)))
        fill_crossings(table, own, columns, out);
}
