/* SPDX-License-Identifier: MIT
 *
 * Rays of a portion, keyed, to their classes. The states of a rank share classes as they go: what
 * few rays have would else be entered once by each thread, and again where states are merged.
 */
#include "analysis/paths/path_count_internal.h"

bool rmap_path_counts_has(const struct rmap_path_counting *context, struct rmap_key key)
{
    if (context->chosen && !rmap_key_sums_find(context->chosen, key))
        return false;
    return !context->sketch || rmap_path_sketch_estimate(context->sketch, key) >=
                                   context->least[rmap_path_source_of(key)];
}

static enum rmap_status add_ray(struct rmap_path_counts *self, const struct rmap_portion *portion,
                                size_t k, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_ray_columns *ray = &portion->ray;
    const struct rmap_path_keyed *keyed = &self->buffers->hasher.keyed;
    const struct rmap_path_target to = {self, portion, &self->tally, NULL};
    const size_t row = keyed->ray[k];
    const double weight = ray->weight[row];
    struct rmap_path_added added;
    const uint32_t before = rmap_path_times_before(keyed, k);
    /* The n-th time adds (n w)^2 - ((n - 1) w)^2: a ray is one contribution. */
    const double squares = (2.0 * before + 1.0) * weight * weight;
    struct rmap_class_sum one = {
        .entry = {.key = rmap_path_key_at(keyed, k),
                  .rays = before == 0,
                  .first_ray = ray->id[row]},
        .more = {weight, squares, before == 0 ? ray->segment_count[row] : 0, 0}};
    if (ray->registration_count[row] > 0)
        RMAP_TRY(rmap_path_counts_add_hits(self, portion, k, &one.more.registrations, err));
    RMAP_TRY(rmap_path_counts_add_class(self, &one, &added, err));
    if (rmap_path_tally_wants_steps(&self->tally, &added))
        st = rmap_path_target_keep_steps(&to, k, &added, err);
out:
    return st;
}

static void expect(const struct rmap_path_counts *self, struct rmap_key key)
{
    const uint64_t mixed = rmap_key_mixed(key);
    if (self->sketch.rays)
        rmap_path_sketch_expect(&self->sketch, key);
    else if (self->context->sketch)
        rmap_path_sketch_expect(self->context->sketch, key);
    else
        rmap_key_slots_expect(&self->tally.classes.slots, &mixed, 1);
}

enum rmap_status rmap_path_counts_ready_cache(struct rmap_path_counts *self, uint64_t first,
                                              uint64_t end, struct rmap_error *err)
{
    struct rmap_class_cache *cache = self->cache;
    struct rmap_path_pool *pool = self->pool;
    bool is_full = false;
    if (!cache)
        return RMAP_OK;
    if (first < cache->end) {
        (void)pthread_mutex_lock(&pool->mutex);
        is_full = pool->is_full;
        if (!is_full)
            rmap_class_cache_empty(cache, &pool->tally.classes);
        (void)pthread_mutex_unlock(&pool->mutex);
    }
    cache->end = end;
    return is_full ? rmap_path_counts_spill(self, err) : RMAP_OK;
}

/* To the classes of all states: *n_ret of the list. */
static enum rmap_status add_to_pool(struct rmap_path_counts *self,
                                    const struct rmap_portion *portion, bool is_wide, size_t *n_ret,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_pool *pool = self->pool;
    const struct rmap_path_target to = {self, portion, &pool->tally, self->cache};
    *n_ret = 0;
    (void)pthread_mutex_lock(&pool->mutex);
    if (pool->is_full)
        goto out;
    if (is_wide)
        RMAP_TRY(rmap_class_sums_widen(&pool->tally.classes, err));
    RMAP_TRY(rmap_path_target_add(&to, n_ret, err));
    self->buffers->ahead = pool->tally.classes.slots;
    if (*n_ret < self->buffers->n_left) {
        pool->is_full = true;
        RMAP_TRY(rmap_path_counts_outline(self, &pool->tally.classes, err));
        rmap_path_tally_fini(&pool->tally);
    }
out:
    (void)pthread_mutex_unlock(&pool->mutex);
    return st;
}

/* *n_ret: how many of the list were added. */
static enum rmap_status add_plain(struct rmap_path_counts *self, const struct rmap_portion *portion,
                                  bool is_wide, size_t *n_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (self->pool) {
        RMAP_TRY(add_to_pool(self, portion, is_wide, n_ret, err));
    } else {
        const struct rmap_path_target to = {self, portion, &self->tally, NULL};
        if (is_wide)
            RMAP_TRY(rmap_class_sums_widen(&self->tally.classes, err));
        RMAP_TRY(rmap_path_target_add(&to, n_ret, err));
    }
    if (*n_ret < self->buffers->n_left)
        RMAP_TRY(rmap_path_counts_spill(self, err));
out:
    return st;
}

enum rmap_status rmap_path_counts_add_keyed(struct rmap_path_counts *self,
                                            const struct rmap_matched *rays, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_keyed *keyed = &self->buffers->hasher.keyed;
    for (size_t k = 0; k < keyed->n; k++) {
        if (k + RMAP_PATH_AHEAD < keyed->n)
            expect(self, rmap_path_key_at(keyed, k + RMAP_PATH_AHEAD));
        if (rmap_path_counts_has(self->context, rmap_path_key_at(keyed, k)))
            RMAP_TRY(add_ray(self, rays->portion, k, err));
    }
out:
    return st;
}

enum rmap_status rmap_path_counts_add_listed(struct rmap_path_counts *self,
                                             const struct rmap_matched *rays, bool is_wide,
                                             struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_buffers *buffers = self->buffers;
    size_t i = 0;
    RMAP_TRY(add_plain(self, rays->portion, is_wide, &i, err));
    if (i < buffers->n_left)
        RMAP_TRY(rmap_fold_fetch(
            rays, RMAP_COLUMN_BIT(RMAP_RAY_id) | RMAP_COLUMN_BIT(RMAP_RAY_weight), err));
    for (; i < buffers->n_left; i++)
        RMAP_TRY(add_ray(self, rays->portion, buffers->left[i], err));
out:
    return st;
}
