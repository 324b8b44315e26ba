/* SPDX-License-Identifier: MIT
 *
 * What the paths of a portion's rays say by themselves, as columns.
 */
#include "compact/decode_paths.h"

#include <string.h>

#include "base/wide.h"
#include "compact/damaged.h"
#include "compact/paths.h"

#define BIT(column) RMAP_COLUMN_BIT(column)

struct rmap_own_paths rmap_own_paths(const struct rmap_compact_model *model,
                                     const struct rmap_path_table *table,
                                     const struct rmap_rows *rows, bool classed)
{
    void *const *data = rows->data;
    const uint32_t *object = data[RMAP_STREAM_OWN_object];
    size_t n_segment = rows->n_row[RMAP_COMPACT_OWN_SEGMENT];
    return (struct rmap_own_paths){.model = model,
                                   .table = table,
                                   .classed = classed,
                                   .n = rows->n_row[RMAP_COMPACT_OWN],
                                   .n_registration = rows->n_row[RMAP_COMPACT_OWN_REGISTRATION],
                                   .n_segment = n_segment,
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

RMAP_WIDE static uint32_t greatest(const uint32_t *number, size_t n)
{
    uint32_t most = 0;
    for (size_t i = 0; i < n; i++)
        most = number[i] > most ? number[i] : most;
    return most;
}

RMAP_WIDE static uint32_t zeros(const uint32_t *number, size_t n)
{
    uint32_t sum = 0;
    for (size_t i = 0; i < n; i++)
        sum += number[i] == 0;
    return sum;
}

/* At most 2^32 rays of 2^32 rows: no sum is too large. */
enum rmap_status rmap_own_paths_check(const struct rmap_own_paths *own,
                                      const size_t n_row[RMAP_TABLE_COUNT], struct rmap_error *err)
{
    const struct rmap_path_table *table = own->table;
    struct rmap_path_count sum = {0};
    uint64_t own_n[2] = {0, 0};
    if (own->path && greatest(own->path, n_row[RMAP_TABLE_RAY]) > table->n)
        return rmap_portion_damaged("a ray refers to a path that is not there", err);
    const uint32_t *path = own->path;
    const size_t n_ray = path ? n_row[RMAP_TABLE_RAY] : 0;
    const size_t n_mine = path ? zeros(path, n_ray) : own->n;
    RMAP_UNROLL
    for (size_t i = 0; i < n_ray; i++) {
        sum.n_segment += table->count[path[i]].n_segment; /* 0 for path 0 */
        sum.n_registration += table->count[path[i]].n_registration;
    }
    for (size_t k = 0; k < own->n; k++) {
        own_n[0] += own->segment_count[k];
        own_n[1] += own->registration_count ? own->registration_count[k] : 0;
    }
    if (n_mine != own->n || own_n[0] != own->n_segment ||
        (own->registration_count && own_n[1] != own->n_registration))
        return rmap_portion_damaged("its own paths have not as many rows as there are", err);
    if (!own->path)
        return RMAP_OK;
    if (sum.n_segment + own_n[0] != n_row[RMAP_TABLE_SEGMENT] ||
        sum.n_registration + own_n[1] != n_row[RMAP_TABLE_REGISTRATION])
        return rmap_portion_damaged("its paths have not as many rows as the index says", err);
    return RMAP_OK;
}

/* What the classes of n segments say. */
static inline void look_up(const struct rmap_step_classes *classes, const uint32_t *class, size_t n,
                           const struct rmap_path_columns *out)
{
    for (size_t k = 0; k < n; k++) {
        const size_t its = class[k] < classes->n ? class[k] : classes->n; /* one more is there */
        const struct rmap_step_class *step = &classes->of[its];
        if (out->object)
            out->object[k] = step->object;
        if (out->event)
            out->event[k] = step->event;
        if (out->medium)
            out->medium[k] = (int16_t)step->medium;
    }
}

void rmap_own_path_unfold(const struct rmap_own_paths *own, size_t k, size_t from,
                          const struct rmap_path_columns *out)
{
    if (own->classed) {
        look_up(&own->table->classes, own->object + from, own->segment_count[k], out);
        return;
    }
    const struct rmap_folded_path path = {.source = own->source[k],
                                          .stop = own->stop[k],
                                          .n = own->segment_count[k],
                                          .object = own->object + from,
                                          .event = own->event + from};
    rmap_path_unfold(own->model, &path, out);
}

/* Those of rows from `row` on. */
static inline struct rmap_path_columns rows_from(const struct rmap_path_columns *all, size_t row)
{
    return (struct rmap_path_columns){.object = all->object ? all->object + row : NULL,
                                      .event = all->event ? all->event + row : NULL,
                                      .medium = all->medium ? all->medium + row : NULL};
}

static struct rmap_path_columns table_rows(const struct rmap_path_table *table)
{
    return (struct rmap_path_columns){
        .object = table->object, .event = table->event, .medium = table->medium};
}

static inline void copy_segments(const struct rmap_path_columns *from, size_t n,
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
static void fill_segments(const struct rmap_own_paths *own, size_t n_ray,
                          const struct rmap_path_columns *out)
{
    const struct rmap_path_table *table = own->table;
    const struct rmap_path_columns known = table_rows(table);
    size_t k = 0, from = 0, to = 0;
    for (size_t i = 0; i < n_ray; i++) {
        const struct rmap_path_columns segments = rows_from(out, to);
        if (own->path[i] == 0) {
            const size_t n = own->segment_count[k];
            rmap_own_path_unfold(own, k++, from, &segments);
            from += n;
            to += n;
            continue;
        }
        const uint32_t path = own->path[i] - 1;
        const size_t n = table->rays.ray.segment_count[path];
        const struct rmap_path_columns its = rows_from(&known, table->first_segment[path]);
        copy_segments(&its, n, &segments);
        to += n;
    }
}

/* Registrations of paths: their own ones, or the table's. */
struct crossings {
    const uint32_t *segment;
    const int32_t *detector;
    const uint8_t *registered;
    size_t n; /* rows */
};

static inline void copy_crossings(const struct crossings *from, size_t row, size_t n,
                                  rmap_column_set columns,
                                  const struct rmap_registration_columns *out, size_t to)
{
    if (columns & BIT(RMAP_REGISTRATION_segment))
        memcpy(out->segment + to, from->segment + row, n * sizeof *out->segment);
    if (columns & BIT(RMAP_REGISTRATION_detector))
        memcpy(out->detector + to, from->detector + row, n * sizeof *out->detector);
    if (columns & BIT(RMAP_REGISTRATION_registered))
        memcpy(out->registered + to, from->registered + row, n * sizeof *out->registered);
}

/* Some rays in a row. */
enum { GROUP = 256 };
struct group {
    size_t n, n_own;
    uint32_t known[GROUP]; /* the path of each in the table; of those with their own, any */
    uint32_t own[GROUP];   /* [n_own] which have their own */
    uint32_t size[GROUP];  /* registrations of each, */
    size_t row[GROUP];     /* from here on */
};

static inline void enter_group(const uint32_t *path, size_t n, struct group *group)
{
    size_t n_own = 0;
    for (size_t i = 0; i < n; i++)
        group->known[i] = path[i] - (path[i] > 0);
    for (size_t i = 0; i < n; i++) {
        group->own[n_own] = (uint32_t)i;
        n_own += path[i] == 0;
    }
    group->n = n;
    group->n_own = n_own;
}

/* A column of the group: as if all paths were known; that of the m-th with its own takes its place.
 */
#define FILL(to, of_known, of_own)                                                                 \
    do {                                                                                           \
        for (size_t i = 0; i < group.n; i++)                                                       \
            (to)[i] = (of_known)[group.known[i]];                                                  \
        for (size_t m = 0; m < group.n_own; m++)                                                   \
            (to)[group.own[m]] = (of_own);                                                         \
    } while (0)

/* The registrations of a group, from row `to` of n_row on; returns the row behind them. Most rays
 * have few: four are copied where there is room, into rows that are filled later if they are not
 * the path's. */
static inline size_t fill_crossings(const struct group *group, const uint32_t *path,
                                    const struct crossings from[2], rmap_column_set columns,
                                    const struct rmap_registration_columns *hit, size_t to,
                                    size_t n_row)
{
    enum { FEW = 4 };
    for (size_t i = 0; i < group->n; to += group->size[i++]) {
        const struct crossings *c = &from[path[i] > 0]; /* no branch: it is random */
        const size_t row = group->row[i], size = group->size[i];
        const size_t done = to + FEW <= n_row && row + FEW <= c->n ? FEW : 0;
        if (done > 0)
            copy_crossings(c, row, FEW, columns, hit, to);
        if (done < size)
            copy_crossings(c, row + done, size - done, columns, hit, to + done);
    }
    return to;
}

/* Heads and registrations. */
RMAP_WIDE
static void fill_rays(const struct rmap_path_table *table, const struct rmap_own_paths *own,
                      rmap_column_set columns, struct rmap_portion *out)
{
    const rmap_column_set usual =
        BIT(RMAP_REGISTRATION_detector) | BIT(RMAP_REGISTRATION_registered);
    const struct crossings from[2] = {
        {own->segment, own->detector, own->registered, own->n_registration},
        {table->segment, table->detector, table->registered, table->n_registration}};
    const struct rmap_ray_columns ray = out->ray, known = table->rays.ray;
    const struct rmap_registration_columns hit = out->registration;
    const size_t n_ray = out->n_row[RMAP_TABLE_RAY];
    const size_t n_row = columns & RMAP_CROSSING_COLUMNS ? out->n_row[RMAP_TABLE_REGISTRATION] : 0;
    struct group group;
    size_t to = 0, k = 0, next = 0;
    for (size_t first = 0; first < n_ray; first += group.n, k += group.n_own) {
        const uint32_t *path = own->path + first;
        enter_group(path, n_ray - first < GROUP ? n_ray - first : GROUP, &group);
        if (columns & BIT(RMAP_RAY_source))
            FILL(ray.source + first, known.source, own->source[k + m]);
        if (columns & BIT(RMAP_RAY_stop))
            FILL(ray.stop + first, known.stop, own->stop[k + m]);
        if (columns & BIT(RMAP_RAY_start_object))
            FILL(ray.start_object + first, table->start_object,
                 (int32_t)own->start_object[k + m] - 1);
        if (columns & BIT(RMAP_RAY_segment_count))
            FILL(ray.segment_count + first, known.segment_count, own->segment_count[k + m]);
        if (n_row > 0 || columns & BIT(RMAP_RAY_registration_count))
            FILL(group.size, known.registration_count, own->registration_count[k + m]);
        if (columns & BIT(RMAP_RAY_registration_count))
            memcpy(ray.registration_count + first, group.size, group.n * sizeof *group.size);
        if (n_row == 0)
            continue;
        for (size_t i = 0; i < group.n; i++)
            group.row[i] = table->first_registration[group.known[i]];
        for (size_t m = 0; m < group.n_own; next += own->registration_count[k + m++])
            group.row[group.own[m]] = next;
        to = (columns & RMAP_CROSSING_COLUMNS) == usual /* known as it is compiled */
                 ? fill_crossings(&group, path, from, usual, &hit, to, n_row)
                 : fill_crossings(&group, path, from, columns, &hit, to, n_row);
    }
}

static struct rmap_path_columns segment_columns(rmap_column_set columns,
                                                const struct rmap_portion *out)
{
    return (struct rmap_path_columns){
        .object = columns & BIT(RMAP_SEGMENT_object) ? out->segment.object : NULL,
        .event = columns & BIT(RMAP_SEGMENT_event) ? out->segment.event : NULL,
        .medium = columns & BIT(RMAP_SEGMENT_medium) ? out->segment.medium : NULL};
}

void rmap_paths_fill(const struct rmap_own_paths *own, rmap_column_set columns,
                     struct rmap_portion *out)
{
    const struct rmap_path_table *table = own->table;
    size_t n_ray = out->n_row[RMAP_TABLE_RAY];
    if (columns & (RMAP_HEAD_COLUMNS | RMAP_CROSSING_COLUMNS))
        fill_rays(table, own, columns, out);
    const struct rmap_path_columns segments = segment_columns(columns, out);
    if (segments.object || segments.event)
        fill_segments(own, n_ray, &segments);
}

static void copy(void *to, const void *from, size_t nbytes)
{
    if (nbytes > 0)
        memcpy(to, from, nbytes);
}

void rmap_own_paths_unfold(const struct rmap_own_paths *own, rmap_column_set columns,
                           struct rmap_portion *out)
{
    const struct rmap_ray_columns *ray = &out->ray;
    const struct rmap_registration_columns *hit = &out->registration;
    const struct rmap_path_columns segments = segment_columns(columns, out);
    copy(ray->segment_count, own->segment_count, own->n * sizeof *ray->segment_count);
    if (columns & BIT(RMAP_RAY_source))
        copy(ray->source, own->source, own->n * sizeof *ray->source);
    if (columns & BIT(RMAP_RAY_stop))
        copy(ray->stop, own->stop, own->n * sizeof *ray->stop);
    if (columns & BIT(RMAP_RAY_registration_count))
        copy(ray->registration_count, own->registration_count,
             own->n * sizeof *ray->registration_count);
    if (columns & BIT(RMAP_REGISTRATION_segment))
        copy(hit->segment, own->segment, own->n_registration * sizeof *hit->segment);
    if (columns & BIT(RMAP_REGISTRATION_detector))
        copy(hit->detector, own->detector, own->n_registration * sizeof *hit->detector);
    if (columns & BIT(RMAP_REGISTRATION_registered))
        copy(hit->registered, own->registered, own->n_registration * sizeof *hit->registered);
    const bool any = segments.object || segments.event || segments.medium;
    if (any && own->classed) {
        look_up(&own->table->classes, own->object, own->n_segment, &segments);
        return;
    }
    for (size_t k = 0, from = 0; any && k < own->n; from += own->segment_count[k++]) {
        const struct rmap_path_columns to = rows_from(&segments, from);
        rmap_own_path_unfold(own, k, from, &to);
    }
}
