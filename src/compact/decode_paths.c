/* SPDX-License-Identifier: MIT */
#include "compact/decode_paths.h"

#include <string.h>

#include "compact/path_wide.h"

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

/* Path k of the portion's own, whose legs begin at row `from`. */
static inline struct rmap_folded_path own_path(const struct rmap_own_paths *own, size_t k,
                                               size_t from)
{
    return (struct rmap_folded_path){.source = own->source[k],
                                     .stop = own->stop[k],
                                     .guided = own->guided,
                                     .n = own->segment_count[k],
                                     .n_stored = own->n_segment - from,
                                     .object = own->object + from,
                                     .event = own->event + from};
}

/* Those of rows from `row` on. */
static inline struct rmap_path_columns rows_from(const struct rmap_path_columns *all, size_t row)
{
    return (struct rmap_path_columns){.n_row = all->n_row - row,
                                      .object = all->object ? all->object + row : NULL,
                                      .event = all->event ? all->event + row : NULL,
                                      .medium = all->medium ? all->medium + row : NULL};
}

static struct rmap_path_columns table_rows(const struct rmap_path_table *table)
{
    return (struct rmap_path_columns){.n_row = table->n_segment,
                                      .object = table->object,
                                      .event = table->event,
                                      .medium = table->medium};
}

static inline void copy_legs(const struct rmap_path_columns *from, size_t n,
                             const struct rmap_path_columns *to)
{
    if (to->object)
        memcpy(to->object, from->object, n * sizeof *to->object);
    if (to->event)
        memcpy(to->event, from->event, n * sizeof *to->event);
    if (to->medium)
        memcpy(to->medium, from->medium, n * sizeof *to->medium);
}

/* Objects, events, and media as the paths say. */
static void fill_legs(const struct rmap_path_table *table, const struct rmap_own_paths *own,
                      size_t n_ray, const struct rmap_path_columns *out)
{
    const struct rmap_path_columns known = table_rows(table);
    size_t k = 0, from = 0, to = 0;
    for (size_t i = 0; i < n_ray; i++) {
        const struct rmap_path_columns legs = rows_from(out, to);
        if (own->path[i] == 0) {
            const struct rmap_folded_path path = own_path(own, k++, from);
            rmap_path_unfold(own->model, &path, &legs);
            from += path.n;
            to += path.n;
            continue;
        }
        const struct rmap_known_path *path = &table->path[own->path[i] - 1];
        const struct rmap_path_columns its = rows_from(&known, path->segment);
        copy_legs(&its, path->n_segment, &legs);
        to += path->n_segment;
    }
}

#ifdef RMAP_PATHS_AVX2
/* Known paths that will be copied soon: where their legs are, and these. */
static inline void expect(const struct rmap_path_table *table, const uint32_t *path, size_t n)
{
    enum { WHERE = 16, LEGS = 8 };
    const uint32_t where = n > WHERE && path[WHERE] > 0 ? path[WHERE] - 1 : 0;
    const uint32_t legs = n > LEGS && path[LEGS] > 0 ? path[LEGS] - 1 : 0;
    __builtin_prefetch(&table->path[where]);
    size_t row = table->n > 0 ? table->path[legs].segment : 0;
    __builtin_prefetch(table->object + row);
    __builtin_prefetch(table->event + row);
    __builtin_prefetch(table->medium + row);
}

/* The same, eight legs at once. Both columns are asked for. What is written beyond a path belongs
 * to later ones. */
RMAP_PATHS_AVX2 static void fill_legs_8(const struct rmap_path_table *table,
                                        const struct rmap_own_paths *own, size_t n_ray,
                                        const struct rmap_path_columns *out)
{
    const struct rmap_path_columns known = table_rows(table);
    size_t k = 0, from = 0, to = 0;
    for (size_t i = 0; i < n_ray; i++) {
        const struct rmap_path_columns legs = rows_from(out, to);
        expect(table, own->path + i, n_ray - i);
        if (own->path[i] == 0) {
            const struct rmap_folded_path path = own_path(own, k++, from);
            if (!rmap_path_unfold_8(own->model, &path, &legs))
                rmap_path_unfold(own->model, &path, &legs);
            else
                rmap_path_end(&path, &legs);
            from += path.n;
            to += path.n;
            continue;
        }
        const struct rmap_known_path *path = &table->path[own->path[i] - 1];
        const struct rmap_path_columns its = rows_from(&known, path->segment);
        size_t n = path->n_segment, whole = (n + 7) / 8 * 8;
        bool room = whole <= legs.n_row && whole <= its.n_row;
        for (size_t j = 0; room && j < n; j += 8)
            copy_8(&its, j, &legs);
        if (!room)
            copy_legs(&its, n, &legs);
        to += n;
    }
}

static bool eight_at_once(const struct rmap_own_paths *own, const struct rmap_path_columns *out)
{
    return (own->guided || own->n == 0) && out->object && out->event &&
           __builtin_cpu_supports("avx2");
}
#else
static bool eight_at_once(const struct rmap_own_paths *own, const struct rmap_path_columns *out)
{
    (void)own;
    (void)out;
    return false;
}
#define fill_legs_8 fill_legs
#endif

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
    size_t n_ray = out->n_row[RMAP_TABLE_RAY];
    if (columns & RMAP_HEAD_COLUMNS)
        fill_heads(table, own, columns, out);
    const struct rmap_path_columns legs = {
        .n_row = out->n_row[RMAP_TABLE_SEGMENT],
        .object = columns & BIT(RMAP_SEGMENT_object) ? out->segment.object : NULL,
        .event = columns & BIT(RMAP_SEGMENT_event) ? out->segment.event : NULL,
        .medium = columns & BIT(RMAP_SEGMENT_medium) ? out->segment.medium : NULL};
    if (legs.object || legs.event)
        (eight_at_once(own, &legs) ? fill_legs_8 : fill_legs)(table, own, n_ray, &legs);
    if (columns & (BIT(RMAP_REGISTRATION_segment) | BIT(RMAP_REGISTRATION_detector) |
                   BIT(RMAP_REGISTRATION_registered)))
        fill_crossings(table, own, columns, out);
}
