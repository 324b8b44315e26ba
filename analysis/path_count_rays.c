/* SPDX-License-Identifier: MIT
 *
 * Rays of a portion, keyed, to their classes. The states of a rank share classes as they go: what
 * few rays have would else be entered once by each thread, and again where states are merged.
 */
#include "analysis/path_count_internal.h"

enum { TOGETHER = RMAP_PATH_TOGETHER };

/* Where rays go. */
struct target {
    const struct rmap_path_counts *counts;
    const struct rmap_portion *portion;
    struct rmap_path_tally *tally;
    struct rmap_class_cache *cache; /* of its classes; NULL: none */
};

/* By a ray of the portion in hand. */
static enum rmap_status keep_steps(const struct target *to,
                                   const struct rmap_path_place_of_ray *place,
                                   const struct rmap_path_added *added, struct rmap_error *err)
{
    rmap_path_step *step;
    enum rmap_status st =
        rmap_path_tally_make_room(to->tally, to->portion, place, added, &step, err);
    if (step)
        rmap_path_steps_end_class(
            &to->tally->steps, added->class,
            rmap_path_hasher_steps(&to->counts->buffers->hasher, place, step));
    return st;
}

/* Numbers of a cell's entry: the last ray, and what it brought so far in weights. */
enum { LAST_RAY, LAST_COUNT };

static struct rmap_key cell_key(struct rmap_key class, int32_t detector, uint32_t cell)
{
    return (struct rmap_key){class.low,
                             UINT64_C(1) << 63 | (uint64_t)(uint32_t)detector << 32 | cell};
}

struct rmap_path_cell rmap_path_cell_of(const struct rmap_key_sum *entry)
{
    return (struct rmap_path_cell){entry->key.low, (int32_t)(entry->key.high >> 32 & INT32_MAX),
                                   (uint32_t)entry->key.high};
}

/* The ray's k-th registration in the cell makes its contribution k w: (k w)^2 - ((k - 1) w)^2. */
static enum rmap_status add_cell(struct rmap_path_counts *self, struct rmap_key key, uint64_t ray,
                                 double weight, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_key_sum *sum = NULL;
    RMAP_TRY(rmap_key_sums_enter(&self->cells, key, &sum, err));
    if (!sum) {
        rmap_path_counts_drop_cells(self);
        goto out;
    }
    bool again = sum->number[LAST_COUNT] > 0 && sum->number[LAST_RAY] == ray;
    uint64_t k = again ? sum->number[LAST_COUNT] + 1 : 1;
    sum->number[LAST_RAY] = ray;
    sum->number[LAST_COUNT] = k;
    sum->weight += weight;
    sum->weight_squared += (2.0 * (double)k - 1.0) * weight * weight;
out:
    return st;
}

/* A ray's registrations: how many, and each in its cell. */
static enum rmap_status add_hits(struct rmap_path_counts *self, const struct rmap_portion *portion,
                                 const struct rmap_path_of_ray *its, uint64_t *n_hit,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_counting *context = self->context;
    const struct rmap_detector *detector =
        rmap_scene_with(context->map, context->overlay)->detector;
    const struct rmap_registration_columns *hit = &portion->registration;
    size_t first = its->place.registration;
    size_t last = first + portion->ray.registration_count[its->place.ray];
    *n_hit = 0;
    for (size_t i = first; i < last; i++) {
        int32_t d = hit->detector[i];
        if (!hit->registered[i] || (context->detector >= 0 && d != context->detector))
            continue;
        ++*n_hit;
        if (self->cells_full || context->most_cells == 0)
            continue;
        uint32_t cell = hit->cell[2 * i] + hit->cell[2 * i + 1] * detector[d].cells[0];
        RMAP_TRY(add_cell(self, cell_key(its->key, d, cell), portion->ray.id[its->place.ray],
                          portion->ray.weight[its->place.ray], err));
    }
out:
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
    const size_t row = its->place.ray;
    const double weight = ray->weight[row];
    struct rmap_path_added added;
    struct rmap_class_sum one = {.entry = {.key = its->key, .rays = 1, .first_ray = ray->id[row]},
                                 .more = {weight, weight * weight, ray->segment_count[row], 0}};
    if (ray->registration_count[row] > 0)
        RMAP_TRY(add_hits(self, portion, its, &one.more.registrations, err));
    RMAP_TRY(rmap_path_counts_add_class(self, &one, &added, err));
    if (rmap_path_tally_wants_steps(&self->tally, &added))
        st = keep_steps(&(struct target){self, portion, &self->tally, NULL}, &its->place, &added,
                        err);
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

/* Whether a ray's key alone says what it is added to. */
static bool is_plain(const struct rmap_path_counts *self)
{
    const struct rmap_path_counting *context = self->context;
    return !self->is_full && !context->chosen && !context->sketch && context->detector < 0;
}

/* What a ray brings to its class. */
static inline void add_to(const struct rmap_class_sums *classes, size_t class,
                          const struct rmap_ray_columns *ray, const struct rmap_path_of_ray *its)
{
    const size_t row = its->place.ray;
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
    const size_t row = its->place.ray;
    struct rmap_class_entry *entry = &classes->entry[class];
    entry->rays = 1;
    entry->first_ray = ray->id[row];
    if (classes->is_wide)
        classes->more[class] =
            (struct rmap_class_more){ray->weight[row], ray->weight[row] * ray->weight[row],
                                     ray->segment_count[row], its->n_hit};
    else
        classes->shape[class] =
            (struct rmap_class_shape){ray->segment_count[row], (uint32_t)its->n_hit};
}

/* Up to TOGETHER listed rays. */
struct together {
    size_t n;
    uint64_t mixed[TOGETHER];
    /* Those whose classes may want steps, and what became of them. */
    size_t n_noted, noted[TOGETHER];
    struct rmap_path_added added[TOGETHER];
};

/* Their keys are mixed, and their slots expected. */
static inline void expect_some(const struct rmap_class_sums *classes,
                               const struct rmap_path_of_ray *list, size_t n, struct together *some)
{
    some->n = n < TOGETHER ? n : TOGETHER;
    for (size_t k = 0; k < some->n; k++)
        some->mixed[k] = rmap_key_mixed(list[k].key);
    rmap_key_slots_expect(&classes->slots, some->mixed, some->n);
}

/* From the k-th on, as long as there is room for new classes; returns the first that there is none
 * for. */
static inline size_t enter_some(const struct target *to, const struct rmap_path_of_ray *list,
                                struct together *some, size_t k)
{
    const struct rmap_ray_columns ray = to->portion->ray;
    struct rmap_class_sums classes = to->tally->classes; /* of which registers know */
    const uint64_t fewest_new = to->tally->steps.is_closed ? 1 : 0;
    const uint64_t fewest = to->tally->steps.is_full ? 2 : fewest_new;
    size_t n_noted = 0, slot = 0;
    for (; k < some->n; k++) {
        const struct rmap_path_of_ray *its = &list[k];
        const uint64_t mixed = some->mixed[k];
        size_t class = rmap_class_sums_look(&classes, its->key, mixed, &slot);
        uint64_t before = 0;
        if (class != RMAP_KEY_SLOTS_NONE) {
            before = classes.entry[class].rays;
            add_to(&classes, class, &ray, its);
            if (to->cache)
                rmap_class_cache_meet(to->cache, its->key, mixed, class, &to->tally->classes);
        } else {
            if (classes.n >= classes.room)
                break;
            class = rmap_class_sums_put(&classes, its->key, mixed, slot);
            begin(&classes, class, &ray, its);
        }
        some->noted[n_noted] = k;
        some->added[n_noted] = (struct rmap_path_added){class, before, before + 1};
        n_noted += before >= fewest && before < 2;
    }
    some->n_noted = n_noted;
    to->tally->classes.n = classes.n;
    return k;
}

static enum rmap_status keep_noted(const struct target *to, const struct rmap_path_of_ray *list,
                                   const struct together *some, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < some->n_noted && st == RMAP_OK; i++)
        if (rmap_path_tally_wants_steps(to->tally, &some->added[i]))
            st = keep_steps(to, &list[some->noted[i]].place, &some->added[i], err);
    return st;
}

/* *n_ret: how many were added: all, unless there are more classes than may be. */
static enum rmap_status add_together(const struct target *to, const struct rmap_path_of_ray *list,
                                     struct together *some, size_t *n_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t k = 0, slot;
    bool is_full = false;
    while (k < some->n && !is_full) {
        k = enter_some(to, list, some, k);
        RMAP_TRY(keep_noted(to, list, some, err));
        if (k < some->n)
            RMAP_TRY(rmap_class_sums_make_room(&to->tally->classes, list[k].key, some->mixed[k],
                                               &slot, &is_full, err));
    }
out:
    *n_ret = k;
    return st;
}

/* Adds listed rays; *n_ret as above. */
static enum rmap_status add_some(const struct target *to, const struct rmap_path_of_ray *list,
                                 size_t n, size_t *n_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_class_sums *classes = &to->tally->classes;
    struct together some[2];
    size_t i = 0, n_added = 0;
    expect_some(classes, list, n, &some[0]);
    for (int turn = 0; some[turn].n > 0; turn ^= 1) {
        struct together *now = &some[turn];
        expect_some(classes, list + i + now->n, n - i - now->n, &some[turn ^ 1]);
        RMAP_TRY(add_together(to, list + i, now, &n_added, err));
        i += n_added;
        if (n_added < now->n)
            break;
    }
out:
    *n_ret = i;
    return st;
}

/* Counts those of n listed rays whose classes are in the cache; the others are moved to the front.
 * Returns how many they are. */
static size_t count_cached(struct rmap_class_cache *cache, const struct rmap_ray_columns *ray,
                           struct rmap_path_of_ray *list, size_t n)
{
    size_t n_left = 0;
    for (size_t i = 0; i < n; i++) {
        const struct rmap_path_of_ray its = list[i];
        list[n_left] = its;
        n_left += !rmap_class_cache_count(cache, its.key, rmap_key_mixed(its.key),
                                          ray->id[its.place.ray]);
    }
    return n_left;
}

/* To the classes of all states: *n_ret of the n first listed rays. */
static enum rmap_status add_to_pool(struct rmap_path_counts *self,
                                    const struct rmap_portion *portion, bool is_wide, size_t n,
                                    size_t *n_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_pool *pool = self->pool;
    const struct target to = {self, portion, &pool->tally, self->cache};
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

/* *first_ret: from here on rays of the list are not counted yet; the last of them is in front of
 * *last_ret. */
static enum rmap_status add_plain(struct rmap_path_counts *self, const struct rmap_portion *portion,
                                  bool is_wide, size_t *first_ret, size_t *last_ret,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_buffers *buffers = self->buffers;
    *last_ret = buffers->n_ray;
    if (self->cache && !is_wide)
        *last_ret = count_cached(self->cache, &portion->ray, buffers->ray, buffers->n_ray);
    if (self->pool) {
        RMAP_TRY(add_to_pool(self, portion, is_wide, *last_ret, first_ret, err));
    } else {
        const struct target to = {self, portion, &self->tally, NULL};
        if (is_wide)
            RMAP_TRY(rmap_class_sums_widen(&self->tally.classes, err));
        RMAP_TRY(add_some(&to, buffers->ray, *last_ret, first_ret, err));
    }
    if (*first_ret < *last_ret)
        RMAP_TRY(rmap_path_counts_spill(self, err));
out:
    return st;
}

static enum rmap_status add_cells(struct rmap_path_counts *self, const struct rmap_portion *portion,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_buffers *buffers = self->buffers;
    uint64_t n_hit;
    for (size_t i = 0; i < buffers->n_ray && !self->cells_full; i++)
        if (buffers->ray[i].n_hit > 0)
            RMAP_TRY(add_hits(self, portion, &buffers->ray[i], &n_hit, err));
out:
    return st;
}

enum rmap_status rmap_path_counts_add_listed(struct rmap_path_counts *self,
                                             const struct rmap_portion *portion, bool is_wide,
                                             struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_buffers *buffers = self->buffers;
    size_t first = 0, last = buffers->n_ray;
    if (is_plain(self)) {
        if (self->context->most_cells > 0)
            RMAP_TRY(add_cells(self, portion, err));
        RMAP_TRY(add_plain(self, portion, is_wide, &first, &last, err));
    }
    for (size_t i = first; i < last; i++) {
        if (i + RMAP_PATH_AHEAD < last)
            expect(self, buffers->ray[i + RMAP_PATH_AHEAD].key);
        if (rmap_path_counts_has(self->context, buffers->ray[i].key))
            RMAP_TRY(add_ray(self, portion, &buffers->ray[i], err));
    }
out:
    return st;
}
