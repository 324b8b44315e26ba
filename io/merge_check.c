/* SPDX-License-Identifier: MIT
 *
 * May maps be one?
 */
#include "io/merge.h"

#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "io/map_internal.h"
#include "io/map_run.h"

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

/* The first ray of both, or none. */
static enum rmap_status find_shared(const struct reading *self, const struct held *a,
                                    const struct held *b, bool *shared, uint64_t *ray,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *x = NULL, *y = NULL;
    *shared = false;
    *ray = b->info->first_ray;
    if (!rmap_portion_has_gaps(a->info) && !rmap_portion_has_gaps(b->info)) {
        *shared = true;
        return RMAP_OK;
    }
    RMAP_TRY(read_ids(self, a, &x, err));
    RMAP_TRY(read_ids(self, b, &y, err));
    for (size_t i = 0, k = 0; i < x->n_row[RMAP_TABLE_RAY] && k < y->n_row[RMAP_TABLE_RAY];) {
        *ray = x->ray.id[i];
        *shared = *ray == y->ray.id[k];
        if (*shared)
            break;
        if (*ray < y->ray.id[k])
            i++;
        else
            k++;
    }
out:
    return st;
}

static enum rmap_status share_rays(const struct rmap_merge_source *source, const struct held *a,
                                   const struct held *b, uint64_t first, struct rmap_error *err)
{
    uint64_t end = rmap_portion_end(a->info) < rmap_portion_end(b->info)
                       ? rmap_portion_end(a->info)
                       : rmap_portion_end(b->info);
    if (rmap_portion_has_gaps(a->info) || rmap_portion_has_gaps(b->info))
        return rmap_error_set(err, RMAP_INPUT,
                              "%s and %s both hold ray %llu: only maps of different rays can be "
                              "merged",
                              source[a->source].path, source[b->source].path,
                              (unsigned long long)first);
    return rmap_error_set(err, RMAP_INPUT,
                          "%s and %s both hold the rays %llu to %llu: only maps of different "
                          "rays can be merged (trace with --first-ray)",
                          source[a->source].path, source[b->source].path, (unsigned long long)first,
                          (unsigned long long)end - 1);
}

/* Each portion against those before it that reach as far. */
static enum rmap_status compare_held(const struct reading *self, const struct held *held,
                                     size_t total, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < total; i++)
        for (size_t k = i + 1;
             k < total && held[k].info->first_ray < rmap_portion_end(held[i].info); k++) {
            bool shared = false;
            uint64_t ray = 0;
            if (held[i].source == held[k].source) /* its own index was checked when it was opened */
                continue;
            RMAP_TRY(find_shared(self, &held[i], &held[k], &shared, &ray, err));
            if (shared)
                RMAP_TRY(share_rays(self->source, &held[i], &held[k], ray, err));
        }
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
    if (!held || !reading.cursor) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the list of portions");
        goto out;
    }
    for (size_t k = 0; k < n; k++)
        for (size_t i = 0; i < rmap_map_n_portion(source[k].map); i++)
            held[at++] = (struct held){rmap_map_portion(source[k].map, i), k, i};
    if (total > 0)
        qsort(held, total, sizeof *held, by_first);
    st = compare_held(&reading, held, total, err);
out:
    for (size_t k = 0; reading.cursor && k < n; k++)
        rmap_cursor_destroy(reading.cursor[k]);
    rmap_free(reading.cursor);
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
