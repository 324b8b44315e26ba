/* SPDX-License-Identifier: MIT */
#include "analysis/path_count.h"

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
            rmap_class_sums_add_rays(&self->tally.classes, line->class, line->rays,
                                     line->first_ray);
        else if (self->sketch.rays)
            rmap_path_sketch_add(&self->sketch, line->key, line->rays);
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

/* Weights of 1 are counted, which is the same sum. */
static void add_ones(struct rmap_path_counts *self, const struct rmap_portion *portion)
{
    const struct rmap_path_buffers *buffers = self->buffers;
    const struct rmap_ray_columns *ray = &portion->ray;
    const size_t n_source = rmap_map_scene(self->context->map)->n_source;
    for (size_t i = 0; n_source > 1 && i < buffers->n_ray; i++) {
        const size_t source = (size_t)ray->source[buffers->ray[i].place.ray];
        self->total.source_weight[source]++;
        self->total.source_weight_squared[source]++;
    }
    if (n_source == 1) {
        self->total.source_weight[0] += (double)buffers->n_ray;
        self->total.source_weight_squared[0] += (double)buffers->n_ray;
    }
    if (buffers->n_ray > 0 && self->most_weight < 1.0)
        self->most_weight = 1.0;
}

static void add_weights(struct rmap_path_counts *self, const struct rmap_portion *portion)
{
    const struct rmap_path_buffers *buffers = self->buffers;
    const struct rmap_ray_columns *ray = &portion->ray;
    double most = self->most_weight;
    for (size_t i = 0; i < buffers->n_ray; i++) {
        const size_t row = buffers->ray[i].place.ray, source = (size_t)ray->source[row];
        const double weight = ray->weight[row];
        self->total.source_weight[source] += weight;
        self->total.source_weight_squared[source] += weight * weight;
        most = weight > most ? weight : most;
    }
    self->most_weight = most;
}

static void add_totals(struct rmap_path_counts *self, const struct rmap_portion *portion, bool ones)
{
    const struct rmap_path_buffers *buffers = self->buffers;
    uint64_t n_segment = 0;
    for (size_t i = 0; i < buffers->n_ray; i++)
        n_segment += portion->ray.segment_count[buffers->ray[i].place.ray];
    self->total.rays += buffers->n_ray;
    self->total.segments += n_segment;
    if (ones)
        add_ones(self, portion);
    else
        add_weights(self, portion);
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
    RMAP_TRY(rmap_fold_fetch(
        rays, rmap_path_count_columns(self->context) & ~RMAP_PATH_HASH_DEFERRED, err));
    RMAP_TRY(reserve(buffers, rays->n_match, err));
    RMAP_TRY(rmap_path_hasher_enter(&buffers->hasher, self->context->keys, rays, err));
    buffers->n_ray = rmap_path_hasher_list(&buffers->hasher, rays, buffers->ray);
    const bool ones = rmap_weights_are_one(portion->ray.weight, portion->n_row[RMAP_TABLE_RAY]);
    add_totals(self, portion, ones);
    RMAP_TRY(rmap_path_counts_add_listed(self, portion, !ones, err));
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
