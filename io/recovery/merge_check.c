/* SPDX-License-Identifier: MIT
 *
 * May maps be one?
 */
#include "io/recovery/merge.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/grouped.h"
#include "io/map/map_internal.h"
#include "io/map/map_run.h"
#include "portion/ray_plan.h"

/* A portion of one of the maps. */
struct held {
    const struct rmap_portion_info *info;
    size_t source, portion;
};

static int by_first(const void *a, const void *b)
{
    const struct held *x = a, *y = b;
    return (x->info->first_ray > y->info->first_ray) - (x->info->first_ray < y->info->first_ray);
}

/* Ids are read where portions with gaps lie within each other; a cursor per map. */
struct reading {
    const struct rmap_merge_source *source;
    struct rmap_cursor **cursor; /* [n] of maps, made when first needed */
};

static enum rmap_status read_ids(const struct reading *self, const struct held *held,
                                 const struct rmap_portion **rows_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_cursor **cursor = &self->cursor[held->source];
    if (!*cursor)
        st = rmap_cursor_create(self->source[held->source].map, RMAP_COLUMN_BIT(RMAP_RAY_id),
                                cursor, err);
    return st == RMAP_OK ? rmap_cursor_read(*cursor, held->portion, rows_ret, err) : st;
}

/* Rays that two of the maps hold both: the first two that were found. */
struct shared {
    size_t source[2];
    struct rmap_ray_range *range; /* [n], in the order in which they were found */
    size_t n, cap;
};

static enum rmap_status add_shared(struct shared *shared, struct rmap_ray_range range,
                                   struct rmap_error *err)
{
    if (shared->n > 0 && shared->range[shared->n - 1].end == range.first) {
        shared->range[shared->n - 1].end = range.end;
        return RMAP_OK;
    }
    enum rmap_status st = RMAP_RESERVE(shared->range, shared->cap, shared->n + 1, err);
    if (st == RMAP_OK)
        shared->range[shared->n++] = range;
    return st;
}

/* Of two portions, the second of which begins within the first. */
static enum rmap_status find_shared(const struct reading *self, const struct held *a,
                                    const struct held *b, struct shared *shared,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *x = NULL, *y = NULL;
    if (!rmap_portion_has_gaps(a->info) && !rmap_portion_has_gaps(b->info)) {
        uint64_t end = rmap_portion_end(a->info), other = rmap_portion_end(b->info);
        return add_shared(
            shared, (struct rmap_ray_range){b->info->first_ray, end < other ? end : other}, err);
    }
    RMAP_TRY(read_ids(self, a, &x, err));
    RMAP_TRY(read_ids(self, b, &y, err));
    for (size_t i = 0, k = 0; i < x->n_row[RMAP_TABLE_RAY] && k < y->n_row[RMAP_TABLE_RAY];) {
        uint64_t ray = x->ray.id[i];
        if (ray == y->ray.id[k])
            RMAP_TRY(add_shared(shared, (struct rmap_ray_range){ray, ray + 1}, err));
        if (ray < y->ray.id[k])
            i++;
        else
            k++;
    }
out:
    return st;
}

/* "ray 7", "the rays 0 to 4095, 8192 to 9000 and others (12,345 rays)" */
static void name_rays(const struct rmap_ray_set *rays, char *text, size_t cap)
{
    enum { SHOWN = 3 };
    const uint64_t n = rmap_ray_set_count(rays);
    size_t at = (size_t)snprintf(text, cap, "%s", n == 1 ? "ray" : "the rays");
    for (size_t i = 0; i < rays->n && i < SHOWN; i++) {
        const struct rmap_ray_range *range = &rays->range[i];
        at += (size_t)snprintf(text + at, cap - at, "%s%llu", i ? ", " : " ",
                               (unsigned long long)range->first);
        if (range->end - range->first > 1)
            at += (size_t)snprintf(text + at, cap - at, " to %llu",
                                   (unsigned long long)range->end - 1);
    }
    if (n > 1)
        (void)snprintf(text + at, cap - at, "%s (%s)", rays->n > SHOWN ? " and others" : "",
                       rmap_counted(n, "ray").text);
}

static enum rmap_status refuse_shared(const struct rmap_merge_source *source,
                                      const struct shared *shared, struct rmap_error *err)
{
    struct rmap_ray_set rays = {0};
    char text[256];
    enum rmap_status st = rmap_ray_set_make(shared->range, shared->n, &rays, err);
    if (st != RMAP_OK)
        return st;
    name_rays(&rays, text, sizeof text);
    rmap_ray_set_fini(&rays);
    const struct rmap_merge_source *a = &source[shared->source[0]], *b = &source[shared->source[1]];
    return rmap_error_set(
        err, RMAP_INPUT, "%s and %s both hold %s: only maps of different rays can be merged%s",
        a->path, b->path, text, a->map->selection ? "" : " (trace with --first-ray)");
}

/* Each portion against those before it that reach as far. */
static enum rmap_status compare_held(const struct reading *self, const struct held *held,
                                     size_t total, struct shared *shared, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < total; i++)
        for (size_t k = i + 1;
             k < total && held[k].info->first_ray < rmap_portion_end(held[i].info); k++) {
            size_t a = held[i].source, b = held[k].source, low = a < b ? a : b, high = a + b - low;
            if (a == b) /* its own index was checked when it was opened */
                continue;
            if (shared->n == 0)
                memcpy(shared->source, (const size_t[]){low, high}, sizeof shared->source);
            if (shared->source[0] == low && shared->source[1] == high)
                RMAP_TRY(find_shared(self, &held[i], &held[k], shared, err));
        }
    if (shared->n > 0)
        st = refuse_shared(self->source, shared, err);
out:
    return st;
}

static enum rmap_status check_rays(const struct rmap_merge_source *source, size_t n,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t total = 0, at = 0;
    for (size_t k = 0; k < n; k++)
        total += rmap_map_n_portion(source[k].map);
    struct held *held = rmap_alloc(total, sizeof *held);
    struct reading reading = {source, rmap_alloc(n, sizeof *reading.cursor)};
    struct shared shared = {0};
    if (!held || !reading.cursor) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the list of portions");
        goto out;
    }
    for (size_t k = 0; k < n; k++)
        for (size_t i = 0; i < rmap_map_n_portion(source[k].map); i++)
            held[at++] = (struct held){rmap_map_portion(source[k].map, i), k, i};
    if (total > 0)
        qsort(held, total, sizeof *held, by_first);
    st = compare_held(&reading, held, total, &shared, err);
out:
    for (size_t k = 0; reading.cursor && k < n; k++)
        rmap_cursor_destroy(reading.cursor[k]);
    rmap_free(reading.cursor);
    rmap_free(shared.range);
    rmap_free(held);
    return st;
}

/* The flux of picked rays is shared out over all of the map they were picked from. */
static enum rmap_status check_selections(const struct rmap_merge_source *source, size_t k,
                                         struct rmap_error *err)
{
    const struct rmap_selection *a = source[0].map->selection, *b = source[k].map->selection;
    if (!a && !b)
        return RMAP_OK;
    if (a && b && rmap_selection_same_origin(a, b))
        return RMAP_OK;
    return rmap_error_set(err, RMAP_INPUT,
                          "%s: rays that a query picked can only be merged with rays picked from "
                          "the same map: merge the whole maps, and ask the one that they make",
                          source[a ? 0 : k].path);
}

static enum rmap_status check_pieces(const struct rmap_merge_source *source, struct rmap_error *err)
{
    for (size_t i = 0; i < rmap_map_n_piece(source->map); i++)
        if (rmap_map_piece(source->map, i)->is_open)
            return rmap_error_set(err, RMAP_INPUT,
                                  "%s has pieces that were never finished; first: raymap repair %s",
                                  source->path, source->path);
    return rmap_map_check_pieces(source->map, err);
}

enum rmap_status rmap_merge_check(const struct rmap_merge_source *source, size_t n,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t k = 0; k < n; k++) {
        struct rmap_map_run run;
        int32_t space;
        RMAP_TRY(check_pieces(&source[k], err));
        RMAP_TRY(check_selections(source, k, err));
        st = rmap_map_run_init(source[k].map, 0, RMAP_ENCODING_PLAIN, &run, err);
        if (st == RMAP_OK)
            st = rmap_map_admit(source[0].map, &run.run, &space, err);
        rmap_map_run_fini(&run);
        if (st != RMAP_OK) {
            rmap_error_context(err, "%s cannot join", source[k].path);
            goto out;
        }
    }
    RMAP_TRY(check_rays(source, n, err));
out:
    return st;
}
