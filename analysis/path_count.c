/* SPDX-License-Identifier: MIT */
#include "analysis/path_count.h"

#include <string.h>

#include "analysis/path_count_internal.h"
#include "analysis/path_pack.h"
#include "analysis/query_sums.h"
#include "base/alloc.h"

rmap_column_set rmap_path_count_columns(const struct rmap_path_counting *context)
{
    rmap_column_set columns =
        rmap_path_keys_columns(context->keys) | RMAP_COLUMN_BIT(RMAP_RAY_weight);
    return context->most_cells ? columns | RMAP_COLUMN_BIT(RMAP_REGISTRATION_cell) : columns;
}

/* ---- classes and their steps ---- */

void rmap_path_tally_init(struct rmap_path_tally *tally, const struct rmap_path_counting *context)
{
    *tally = (struct rmap_path_tally){0};
    rmap_class_sums_init(&tally->classes, !rmap_path_keys_are_simple(context->keys),
                         context->most_classes);
}

void rmap_path_tally_fini(struct rmap_path_tally *tally)
{
    rmap_class_sums_fini(&tally->classes);
    rmap_path_steps_fini(&tally->steps);
}

enum rmap_status rmap_path_tally_make_room(struct rmap_path_tally *tally,
                                           const struct rmap_portion *portion,
                                           const struct rmap_path_place_of_ray *place,
                                           const struct rmap_path_added *added, rmap_path_step **to,
                                           struct rmap_error *err)
{
    const size_t most = (size_t)portion->ray.segment_count[place->ray] +
                        portion->ray.registration_count[place->ray];
    return rmap_path_steps_make_room(&tally->steps, most, added->after, to, err);
}

enum rmap_status rmap_path_pool_create(const struct rmap_path_counting *context,
                                       struct rmap_path_pool **pool_ret, struct rmap_error *err)
{
    struct rmap_path_pool *pool = rmap_alloc(1, sizeof *pool);
    if (!pool)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for paths");
    (void)pthread_mutex_init(&pool->mutex, NULL);
    rmap_path_tally_init(&pool->tally, context);
    *pool_ret = pool;
    return RMAP_OK;
}

void rmap_path_pool_destroy(struct rmap_path_pool *pool)
{
    if (!pool)
        return;
    rmap_path_tally_fini(&pool->tally);
    (void)pthread_mutex_destroy(&pool->mutex);
    rmap_free(pool);
}

/* ---- states ---- */

static void destroy(void *state)
{
    struct rmap_path_counts *self = state;
    if (!self)
        return;
    if (self->buffers) {
        rmap_path_hasher_fini(&self->buffers->hasher);
        rmap_path_dictionary_fini(&self->buffers->dictionary);
        rmap_free(self->buffers->ray);
        rmap_free(self->buffers->all);
    }
    rmap_free(self->buffers);
    rmap_free(self->cache);
    rmap_path_tally_fini(&self->tally);
    rmap_key_sums_fini(&self->cells);
    rmap_path_sketch_fini(&self->sketch);
    rmap_count_fini(&self->total);
    rmap_free(self);
}

static enum rmap_status create(const void *context_, void **state_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_counting *context = context_;
    struct rmap_path_counts *self = rmap_alloc(1, sizeof *self);
    if (self)
        self->buffers = rmap_alloc(1, sizeof *self->buffers);
    if (!self || !self->buffers) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for paths");
        goto out;
    }
    self->context = context;
    self->pool = context->pool;
    if (context->pool && rmap_path_keys_are_simple(context->keys)) {
        self->cache = rmap_alloc(1, sizeof *self->cache);
        if (!self->cache)
            RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for paths"));
    }
    rmap_path_tally_init(&self->tally, context);
    rmap_key_sums_init(&self->cells, context->most_cells);
    RMAP_TRY(rmap_count_init(&self->total, rmap_map_scene(context->map)->n_source, err));
    *state_ret = self;
    self = NULL;
out:
    destroy(self);
    return st;
}

void rmap_path_counts_drop_cells(struct rmap_path_counts *self)
{
    self->cells_full = true;
    rmap_key_sums_fini(&self->cells);
}

enum rmap_status rmap_path_counts_outline(struct rmap_path_counts *self,
                                          const struct rmap_class_sums *classes,
                                          struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (!self->sketch.rays)
        RMAP_TRY(rmap_path_sketch_init(&self->sketch, err));
    for (size_t i = 0; i < classes->n; i++)
        rmap_path_sketch_add(&self->sketch, classes->entry[i].key, classes->entry[i].rays);
out:
    return st;
}

void rmap_path_counts_take_cache(struct rmap_path_counts *self,
                                 const struct rmap_class_cache *cache)
{
    for (size_t i = 0; cache && i < RMAP_CLASS_CACHE_LINES; i++) {
        const struct rmap_class_line *line = &cache->line[i];
        if (line->rays == 0)
            continue;
        if (!self->is_full)
            rmap_class_sums_add_rays(&self->tally.classes, cache->class[i], line -> rays,
                                     line -> first_ray);
        else if (self->sketch.rays)
            rmap_path_sketch_add(&self->sketch, cache->key[i], line->rays);
    }
}

void rmap_path_counts_drop_cache(struct rmap_path_counts *self)
{
    rmap_free(self->cache);
    self->cache = NULL;
}

/* More classes than may be: from now on there is the sketch alone. */
enum rmap_status rmap_path_counts_spill(struct rmap_path_counts *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (self->is_full)
        return RMAP_OK;
    if (!self->context->sketch)
        RMAP_TRY(rmap_path_counts_outline(self, &self->tally.classes, err));
    self->is_full = self->tally.steps.is_closed = self->tally.steps.is_full = true;
    rmap_path_counts_take_cache(self, self->cache);
    rmap_path_counts_drop_cache(self);
    rmap_path_tally_fini(&self->tally);
    rmap_path_counts_drop_cells(self);
out:
    return st;
}

/* Adds what another entry, or one ray, brings to its class. */
enum rmap_status rmap_path_counts_add_class(struct rmap_path_counts *self,
                                            const struct rmap_class_sum *more,
                                            struct rmap_path_added *added, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    *added = (struct rmap_path_added){.class = RMAP_KEY_SLOTS_NONE};
    if (!self->is_full) {
        RMAP_TRY(
            rmap_class_sums_add(&self->tally.classes, more, &added->class, &added->before, err));
        added->after = added->before + more->entry.rays;
        if (added->class == RMAP_KEY_SLOTS_NONE)
            RMAP_TRY(rmap_path_counts_spill(self, err));
    }
    if (added->class == RMAP_KEY_SLOTS_NONE && self->sketch.rays)
        rmap_path_sketch_add(&self->sketch, more->entry.key, more->entry.rays);
out:
    return st;
}

/* ---- rays of a portion ---- */

static void add_weights(struct rmap_path_counts *self, const struct rmap_portion *portion,
                        const struct rmap_path_of_ray *list, size_t n)
{
    const struct rmap_ray_columns *ray = &portion->ray;
    for (size_t i = 0; i < n; i++) {
        const size_t row = list[i].ray, source = (size_t)ray->source[row];
        const double weight = ray->weight[row];
        self->total.rays++;
        self->total.segments += ray->segment_count[row];
        self->total.source_weight[source] += weight;
        self->total.source_weight_squared[source] += weight * weight;
        self->most_weight = weight > self->most_weight ? weight : self->most_weight;
    }
}

/* All rays that match: they have a path, and weight 1. */
static enum rmap_status add_ones(struct rmap_path_counts *self, const struct rmap_matched *rays,
                                 const struct rmap_sums_facts *facts, struct rmap_error *err)
{
    struct rmap_path_buffers *buffers = self->buffers;
    const size_t n = rays->portion->n_row[RMAP_TABLE_RAY], had = buffers->all_cap;
    void *all = buffers->all;
    enum rmap_status st = RMAP_OK;
    if (!rays->match) {
        st = rmap_reserve(&all, &buffers->all_cap, n, 1, err);
        buffers->all = all;
        RMAP_TRY(st);
        memset(buffers->all + had, 1, buffers->all_cap - had);
    }
    rmap_sums_add_matches(&self->total, rays->portion, rays->match ? rays->match : buffers->all,
                          facts);
    if (rays->n_match > 0 && self->most_weight < 1.0)
        self->most_weight = 1.0;
out:
    return st;
}

static enum rmap_status add_cells(struct rmap_path_counts *self, const struct rmap_portion *portion,
                                  const struct rmap_path_of_ray *list, size_t n,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint64_t n_hit;
    for (size_t i = 0; i < n && !self->cells_full; i++)
        if (list[i].n_hit > 0)
            RMAP_TRY(rmap_path_counts_add_hits(self, portion, &list[i], &n_hit, err));
out:
    return st;
}

/* Counts those of n rays whose classes are in the cache; the others go to a list. Returns how many
 * they are. */
static size_t count_cached(struct rmap_class_cache *cache, const uint64_t *id,
                           const struct rmap_path_of_ray *from, size_t n,
                           struct rmap_path_of_ray *to)
{
    size_t n_left = 0;
    for (size_t i = 0; i < n; i++) {
        const struct rmap_path_of_ray its = from[i];
        to[n_left] = its;
        n_left += !rmap_class_cache_count(cache, its.key, rmap_key_mixed(its.key), id[its.ray]);
    }
    return n_left;
}

/* Keys all rays that have a path; counted: the totals have them by now, and weights are 1. Those
 * that are not counted by the cache are listed in the buffers. */
static enum rmap_status list_rays(struct rmap_path_counts *self, const struct rmap_matched *rays,
                                  bool counted, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_buffers *buffers = self->buffers;
    struct rmap_path_of_ray some[RMAP_PATH_BATCH];
    struct rmap_path_place_of_ray place = {0};
    const bool plain = rmap_path_counts_are_plain(self);
    const bool cells = plain && self->context->most_cells > 0;
    buffers->n_ray = 0;
    for (size_t n; (n = rmap_path_hasher_next(&buffers->hasher, rays, &place, some)) > 0;) {
        struct rmap_path_of_ray *to = buffers->ray + buffers->n_ray;
        if (!counted)
            add_weights(self, rays->portion, some, n);
        if (cells)
            RMAP_TRY(add_cells(self, rays->portion, some, n, err));
        if (plain && counted && self->cache)
            n = count_cached(self->cache, rays->portion->ray.id, some, n, to);
        else
            memcpy(to, some, n * sizeof *some);
        buffers->n_ray += n;
    }
out:
    return st;
}

static enum rmap_status reserve(struct rmap_path_buffers *buffers, size_t n, struct rmap_error *err)
{
    void *block = buffers->ray;
    enum rmap_status st = rmap_reserve(&block, &buffers->ray_cap, n + 1, sizeof *buffers->ray, err);
    buffers->ray = block;
    return st;
}

static enum rmap_status add_rays(struct rmap_path_counts *self, const struct rmap_matched *rays,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *portion = rays->portion;
    struct rmap_path_buffers *buffers = self->buffers;
    struct rmap_sums_facts facts;
    RMAP_TRY(rmap_fold_fetch(
        rays, rmap_path_count_columns(self->context) & ~RMAP_PATH_HASH_DEFERRED, err));
    RMAP_TRY(reserve(buffers, rays->n_match, err));
    RMAP_TRY(rmap_path_hasher_enter(&buffers->hasher, self->context->keys, rays, err));
    RMAP_TRY(rmap_sums_look(portion, rmap_map_scene(self->context->map)->n_source, &facts, err));
    const bool counted = facts.are_counted && rmap_path_keys_are_simple(self->context->keys);
    if (counted)
        RMAP_TRY(add_ones(self, rays, &facts, err));
    RMAP_TRY(list_rays(self, rays, counted, err));
    RMAP_TRY(rmap_path_counts_add_listed(self, portion, !counted, err));
out:
    return st;
}

static enum rmap_status add(void *state, const struct rmap_matched *rays, struct rmap_error *err)
{
    struct rmap_path_counts *self = state;
    const bool cells = self->context->most_cells > 0 && !self->cells_full;
    if (rays->view && rays->view->form == RMAP_HISTORY_PATHS && rays->view->unit_weight && !cells)
        return rmap_path_counts_add_view(self, rays, err);
    return add_rays(self, rays, err);
}

const struct rmap_fold_kind rmap_path_count_kind = {.create = create,
                                                    .destroy = destroy,
                                                    .add = add,
                                                    .merge = rmap_path_counts_merge,
                                                    .settle = rmap_path_counts_settle,
                                                    .pack = rmap_path_counts_pack,
                                                    .unpack = rmap_path_counts_unpack};
