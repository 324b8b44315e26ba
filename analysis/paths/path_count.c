/* SPDX-License-Identifier: MIT */
#include "analysis/paths/path_count.h"

#include <string.h>

#include "analysis/paths/path_count_internal.h"
#include "analysis/paths/path_pack.h"
#include "analysis/query/query_sums.h"
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
        rmap_path_judge_fini(&self->buffers->judge);
        rmap_free(self->buffers->left);
        rmap_free(self->buffers->mixed);
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
        const uint64_t n_ray = cache->rays[i];
        if (n_ray == 0)
            continue;
        if (!self->is_full)
            rmap_class_sums_add_rays(&self->tally.classes, cache->class[i], n_ray);
        else if (self->sketch.rays)
            rmap_path_sketch_add(&self->sketch, cache->key[i], n_ray);
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

/* counted: rays weigh 1, and all that match have a path. */
static enum rmap_status add_totals(struct rmap_path_counts *self, const struct rmap_matched *rays,
                                   const struct rmap_sums_facts *facts, struct rmap_error *err)
{
    struct rmap_path_buffers *buffers = self->buffers;
    const size_t n = rays->portion->n_row[RMAP_TABLE_RAY], had = buffers->all_cap;
    enum rmap_status st = RMAP_OK;
    if (!rays->match) {
        st = RMAP_RESERVE(buffers->all, buffers->all_cap, n, err);
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

/* Of those that are keyed. */
static void add_weights(struct rmap_path_counts *self, const struct rmap_portion *portion)
{
    const struct rmap_ray_columns *ray = &portion->ray;
    const struct rmap_path_keyed *keyed = &self->buffers->hasher.keyed;
    for (size_t i = 0, end; i < keyed->n; i = end) {
        const size_t row = keyed->ray[i], source = (size_t)ray->source[row];
        for (end = i + 1; end < keyed->n && keyed->ray[end] == row; end++) {
            if (rmap_path_times_before(keyed, end) > 0)
                continue;
            self->again.rays++;
            self->again.segments += ray->segment_count[row];
        }
        const double weight = ray->weight[row] * (double)(end - i);
        self->total.rays++;
        self->total.segments += ray->segment_count[row];
        self->total.source_weight[source] += weight;
        self->total.source_weight_squared[source] += weight * weight;
        self->most_weight = weight > self->most_weight ? weight : self->most_weight;
    }
}

/* Rays that were judged after they were keyed may not match. */
static enum rmap_status add_cells(struct rmap_path_counts *self, const struct rmap_matched *rays,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_keyed *keyed = &self->buffers->hasher.keyed;
    uint64_t n_hit;
    for (size_t i = 0; i < keyed->n && !self->cells_full; i++)
        if (keyed->n_hit[i] > 0 && (!rays->match || rays->match[keyed->ray[i]]))
            RMAP_TRY(rmap_path_counts_add_hits(self, rays->portion, i, &n_hit, err));
out:
    return st;
}

/* Reads what is needed, and notes what is told without. */
static enum rmap_status read_rays(struct rmap_path_counts *self, const struct rmap_matched *rays,
                                  bool lean, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *portion = rays->portion;
    struct rmap_fold_told *told = &self->buffers->told;
    rmap_column_set columns = rmap_path_count_columns(self->context) & ~RMAP_PATH_HASH_DEFERRED;
    *told = (struct rmap_fold_told){.source = -1};
    if (lean)
        RMAP_TRY(rmap_fold_tell(rays, told, err));
    if (told->weigh_one)
        columns &= ~RMAP_COLUMN_BIT(RMAP_RAY_weight);
    if (told->ids_run)
        columns &= ~RMAP_COLUMN_BIT(RMAP_RAY_id);
    if (told->source >= 0)
        columns &= ~RMAP_COLUMN_BIT(RMAP_RAY_source);
    RMAP_TRY(rmap_fold_fetch(rays, columns, err));
    if (!told->weigh_one)
        told->weigh_one = rmap_weights_are_one(portion->ray.weight, portion->n_row[RMAP_TABLE_RAY]);
    if (!told->weigh_one)
        st = rmap_fold_fetch(rays, RMAP_COLUMN_BIT(RMAP_RAY_source), err);
out:
    return st;
}

/* Classes of the cache match: where most rays do, those of others alone are judged, after all are
 * keyed. */
static bool judges_left(const struct rmap_path_counts *self, const struct rmap_matched *rays,
                        bool counted, bool plain)
{
    return rays->open && counted && plain && self->cache &&
           rmap_path_judge_expects_most(&self->buffers->judge);
}

static enum rmap_status judge_left(struct rmap_path_counts *self, struct rmap_matched *rays,
                                   const struct rmap_sums_facts *facts, struct rmap_error *err)
{
    struct rmap_path_buffers *buffers = self->buffers;
    const enum rmap_status st =
        rmap_path_judge_left(&buffers->judge, &buffers->hasher, rays, buffers->left, buffers->mixed,
                             &buffers->n_left, err);
    if (st != RMAP_OK)
        return st;
    rmap_key_slots_expect(&buffers->ahead, buffers->mixed, buffers->n_left);
    return add_totals(self, rays, facts, err);
}

enum rmap_status rmap_path_counts_add_rays(struct rmap_path_counts *self,
                                           const struct rmap_matched *entered,
                                           struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_matched rays = *entered;
    const struct rmap_portion *portion = rays.portion;
    const size_t n_source = rmap_map_scene(self->context->map)->n_source;
    struct rmap_path_buffers *buffers = self->buffers;
    const struct rmap_fold_told *told = &buffers->told;
    const bool plain = rmap_path_counts_are_plain(self);
    const bool cells = plain && self->context->most_cells > 0 && !self->cells_full;
    const bool simple = rmap_path_keys_are_simple(self->context->keys);
    struct rmap_sums_facts facts;
    const bool lean = plain && simple && !cells && n_source <= RMAP_SUMS_SOURCES_MAX;
    RMAP_TRY(read_rays(self, &rays, lean, err));
    RMAP_TRY(rmap_path_hasher_enter(&buffers->hasher, self->context->keys, &rays, err));
    RMAP_TRY(rmap_sums_facts(portion, n_source, told->weigh_one, told->source, &facts, err));
    const bool counted = facts.are_counted && simple;
    const bool later = judges_left(self, &rays, counted, plain);
    if (rays.open && !later)
        RMAP_TRY(rmap_path_judge_steps(&buffers->judge, &buffers->hasher, &rays, err));
    if (counted && !later)
        RMAP_TRY(add_totals(self, &rays, &facts, err));
    RMAP_TRY(rmap_path_hasher_place(&buffers->hasher, &rays, err));
    if (!counted)
        add_weights(self, portion);
    if (!plain) {
        rmap_path_hasher_key(&buffers->hasher, 0, buffers->hasher.keyed.n, told->source);
        return rmap_path_counts_add_keyed(self, &rays, err);
    }
    const size_t n_ray = portion->n_row[RMAP_TABLE_RAY];
    const uint64_t end =
        told->ids_run || n_ray == 0 ? portion->first_ray + n_ray : portion->ray.id[n_ray - 1] + 1;
    RMAP_TRY(rmap_path_counts_ready_cache(self, portion->first_ray, end, err));
    RMAP_TRY(rmap_path_buffers_list(buffers, counted ? self->cache : NULL, !later, err));
    if (later)
        RMAP_TRY(judge_left(self, &rays, &facts, err));
    if (cells)
        RMAP_TRY(add_cells(self, &rays, err));
    st = rmap_path_counts_add_listed(self, &rays, !counted, err);
out:
    return st;
}

/* Rays that are open, of which few are expected to match. */
static enum rmap_status add_few(struct rmap_path_counts *self, const struct rmap_matched *all,
                                struct rmap_error *err)
{
    struct rmap_matched rays = *all;
    const enum rmap_status st = rmap_path_judge_columns(&self->buffers->judge, &rays, err);
    return st == RMAP_OK && rays.n_match > 0 ? rmap_path_counts_add_rays(self, &rays, err) : st;
}

static enum rmap_status add(void *state, const struct rmap_matched *rays, struct rmap_error *err)
{
    struct rmap_path_counts *self = state;
    const bool cells = self->context->most_cells > 0 && !self->cells_full;
    struct rmap_told_paths told = {.known = NULL};
    enum rmap_status st = RMAP_OK;
    if (rays->open && rmap_path_judge_expects_few(&self->buffers->judge))
        return add_few(self, rays, err);
    if (rays->view && rays->view->form == RMAP_HISTORY_PATHS && rays->view->unit_weight && !cells)
        return rmap_path_counts_add_view(self, rays, err);
    if (!rays->view && !cells)
        RMAP_TRY(rmap_fold_tell_paths(rays, &told, err));
    st = rmap_path_shares_matter(rays, &told) ? rmap_path_counts_add_told(self, rays, &told, err)
                                              : rmap_path_counts_add_rays(self, rays, err);
out:
    return st;
}

static bool judges(const void *context_, const struct rmap_criterion *criterion)
{
    const struct rmap_path_counting *context = context_;
    return rmap_path_judges(context->keys, criterion);
}

const struct rmap_fold_kind rmap_path_count_kind = {.create = create,
                                                    .destroy = destroy,
                                                    .add = add,
                                                    .judges = judges,
                                                    .merge = rmap_path_counts_merge,
                                                    .settle = rmap_path_counts_settle,
                                                    .pack = rmap_path_counts_pack,
                                                    .unpack = rmap_path_counts_unpack};
