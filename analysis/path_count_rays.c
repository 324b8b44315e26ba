/* SPDX-License-Identifier: MIT
 *
 * Rays of a portion, keyed, to their classes. The states of a rank share classes as they go: what
 * few rays have would else be entered once by each thread, and again where states are merged.
 */
#include "analysis/path_count_internal.h"

/* Where rays go. */
struct target {
    const struct rmap_path_counts *counts;
    const struct rmap_portion *portion;
    struct rmap_path_tally *tally;
    struct rmap_class_cache *cache; /* of its classes; NULL: none */
};

/* By a ray of the portion in hand. */
static enum rmap_status keep_steps(const struct target *to, const struct rmap_path_of_ray *its,
                                   const struct rmap_path_added *added, struct rmap_error *err)
{
    const struct rmap_path_place_of_ray place = rmap_path_place_of(its);
    rmap_path_step *step;
    enum rmap_status st =
        rmap_path_tally_make_room(to->tally, to->portion, &place, added, &step, err);
    if (step)
        rmap_path_steps_end_class(
            &to->tally->steps, added->class,
            rmap_path_hasher_steps(&to->counts->buffers->hasher, &place, step));
    return st;
}

bool rmap_path_counts_has(const struct rmap_path_counting *context, struct rmap_key key)
{
    if (context->chosen && !rmap_key_sums_find(context->chosen, key))
        return false;
    return !context->sketch || rmap_path_sketch_estimate(context->sketch, key) >=
                                   context->least[rmap_path_source_of(key)];
}

static enum rmap_status add_ray(struct rmap_path_counts *self, const struct rmap_portion *portion,
                                const struct rmap_path_of_ray *its, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_ray_columns *ray = &portion->ray;
    const size_t row = its->ray;
    const double weight = ray->weight[row];
    struct rmap_path_added added;
    struct rmap_class_sum one = {.entry = {.key = its->key, .rays = 1, .first_ray = ray->id[row]},
                                 .more = {weight, weight * weight, ray->segment_count[row], 0}};
    if (ray->registration_count[row] > 0)
        RMAP_TRY(rmap_path_counts_add_hits(self, portion, its, &one.more.registrations, err));
    RMAP_TRY(rmap_path_counts_add_class(self, &one, &added, err));
    if (rmap_path_tally_wants_steps(&self->tally, &added))
        st = keep_steps(&(struct target){self, portion, &self->tally, NULL}, its, &added, err);
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

/* What a ray brings to its class. */
static inline void add_to(const struct rmap_class_sums *classes, size_t class,
                          const struct rmap_ray_columns *ray, const struct rmap_path_of_ray *its)
{
    const size_t row = its->ray;
    const uint64_t id = ray->id[row];
    struct rmap_class_entry *entry = &classes->entry[class];
    entry->rays++;
    entry->first_ray = id < entry->first_ray ? id : entry->first_ray;
    if (classes->is_wide) {
        struct rmap_class_more *more = &classes->more[class];
        more->weight += ray->weight[row];
        more->weight_squared += ray->weight[row] * ray->weight[row];
        more->segments += ray->segment_count[row];
        more->registrations += its->n_hit;
    }
}

static inline void begin(const struct rmap_class_sums *classes, size_t class,
                         const struct rmap_ray_columns *ray, const struct rmap_path_of_ray *its)
{
    const size_t row = its->ray;
    struct rmap_class_entry *entry = &classes->entry[class];
    entry->rays = 1;
    entry->first_ray = ray->id[row];
    if (classes->is_wide)
        classes->more[class] =
            (struct rmap_class_more){ray->weight[row], ray->weight[row] * ray->weight[row],
                                     ray->segment_count[row], its->n_hit};
    else
        classes->shape[class] = (struct rmap_class_shape){ray->segment_count[row], its->n_hit};
}

/* Keys of the next rays, mixed: their slots are asked for so far ahead, and half as far their
 * entries. Of many more at once memory forgets some. */
enum { AHEAD = 16 };
struct ahead {
    uint64_t mixed[2 * AHEAD];
};

static inline uint64_t *ahead_of(struct ahead *ahead, size_t i)
{
    return &ahead->mixed[i % (2 * AHEAD)];
}

RMAP_COPIED void expect_slot(const struct rmap_class_sums *classes,
                             const struct rmap_path_of_ray *list, size_t i, struct ahead *ahead)
{
    uint64_t *mixed = ahead_of(ahead, i);
    *mixed = rmap_key_mixed(list[i].key);
    rmap_key_slots_expect(&classes->slots, mixed, 1);
}

RMAP_COPIED void look_ahead(const struct rmap_class_sums *classes,
                            const struct rmap_path_of_ray *list, size_t n, size_t i,
                            struct ahead *ahead)
{
    if (i + AHEAD < n)
        expect_slot(classes, list, i + AHEAD, ahead);
    if (i + AHEAD / 2 < n)
        rmap_key_slots_expect_entries(&classes->slots, classes->entry, sizeof *classes->entry,
                                      ahead_of(ahead, i + AHEAD / 2), 1);
}

/* Adds listed rays from the i-th on. Returns n; or at which it stopped: its class may want steps,
 * or (added->class NONE) it is not added: there is no room for its class. */
static inline size_t enter_some(const struct target *to, const struct rmap_path_of_ray *list,
                                size_t n, size_t i, struct ahead *ahead,
                                struct rmap_path_added *added)
{
    const struct rmap_ray_columns ray = to->portion->ray;
    const struct rmap_path_steps *steps = &to->tally->steps;
    const uint64_t fewest = steps->is_full ? 2 : steps->is_closed;
    struct rmap_class_sums classes = to->tally->classes; /* of which registers know */
    size_t slot = 0;
    for (; i < n; i++) {
        const struct rmap_path_of_ray *its = &list[i];
        const uint64_t mixed = *ahead_of(ahead, i);
        uint64_t before = 0;
        look_ahead(&classes, list, n, i, ahead);
        added->class = rmap_class_sums_look(&classes, its->key, mixed, &slot);
        if (added->class != RMAP_KEY_SLOTS_NONE) {
            before = classes.entry[added->class].rays;
            add_to(&classes, added->class, &ray, its);
            if (to->cache)
                rmap_class_cache_meet(to->cache, its->key, mixed, added->class,
                                      &to->tally->classes);
        } else {
            if (classes.n >= classes.room)
                break;
            added->class = rmap_class_sums_put(&classes, its->key, mixed, slot);
            begin(&classes, added->class, &ray, its);
        }
        if (before >= fewest && before < 2) {
            added->before = before;
            added->after = before + 1;
            break;
        }
    }
    to->tally->classes.n = classes.n;
    return i;
}

/* Adds listed rays; *n_ret: how many: all, unless there are more classes than may be. */
static enum rmap_status add_some(const struct target *to, const struct rmap_path_of_ray *list,
                                 size_t n, size_t *n_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_class_sums *classes = &to->tally->classes;
    struct rmap_path_added added;
    struct ahead ahead;
    size_t i = 0, slot;
    bool is_full = false;
    for (size_t k = 0; k < AHEAD && k < n; k++)
        expect_slot(classes, list, k, &ahead);
    while (!is_full && (i = enter_some(to, list, n, i, &ahead, &added)) < n) {
        if (added.class == RMAP_KEY_SLOTS_NONE)
            RMAP_TRY(rmap_class_sums_make_room(classes, list[i].key, *ahead_of(&ahead, i), &slot,
                                               &is_full, err));
        else if (rmap_path_tally_wants_steps(to->tally, &added))
            RMAP_TRY(keep_steps(to, &list[i++], &added, err));
        else
            i++;
    }
out:
    *n_ret = i;
    return st;
}

/* To the classes of all states: *n_ret of the list. */
static enum rmap_status add_to_pool(struct rmap_path_counts *self,
                                    const struct rmap_portion *portion, bool is_wide, size_t *n_ret,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_pool *pool = self->pool;
    const struct target to = {self, portion, &pool->tally, self->cache};
    const size_t n = self->buffers->n_ray;
    *n_ret = 0;
    (void)pthread_mutex_lock(&pool->mutex);
    if (pool->is_full)
        goto out;
    if (is_wide)
        RMAP_TRY(rmap_class_sums_widen(&pool->tally.classes, err));
    RMAP_TRY(add_some(&to, self->buffers->ray, n, n_ret, err));
    if (*n_ret < n) {
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
    const struct rmap_path_buffers *buffers = self->buffers;
    if (self->pool) {
        RMAP_TRY(add_to_pool(self, portion, is_wide, n_ret, err));
    } else {
        const struct target to = {self, portion, &self->tally, NULL};
        if (is_wide)
            RMAP_TRY(rmap_class_sums_widen(&self->tally.classes, err));
        RMAP_TRY(add_some(&to, buffers->ray, buffers->n_ray, n_ret, err));
    }
    if (*n_ret < buffers->n_ray)
        RMAP_TRY(rmap_path_counts_spill(self, err));
out:
    return st;
}

enum rmap_status rmap_path_counts_add_listed(struct rmap_path_counts *self,
                                             const struct rmap_portion *portion, bool is_wide,
                                             struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_buffers *buffers = self->buffers;
    const struct rmap_path_of_ray *list = buffers->ray;
    size_t i = 0;
    if (rmap_path_counts_are_plain(self))
        RMAP_TRY(add_plain(self, portion, is_wide, &i, err));
    for (; i < buffers->n_ray; i++) {
        if (i + RMAP_PATH_AHEAD < buffers->n_ray)
            expect(self, list[i + RMAP_PATH_AHEAD].key);
        if (rmap_path_counts_has(self->context, list[i].key))
            RMAP_TRY(add_ray(self, portion, &list[i], err));
    }
out:
    return st;
}
