/* SPDX-License-Identifier: MIT */
#include "analysis/path_count.h"

#include <inttypes.h>
#include <string.h>

#include "analysis/path_count_internal.h"
#include "analysis/path_pack.h"
#include "analysis/query_sums.h"
#include "base/alloc.h"

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

rmap_column_set rmap_path_count_columns(const struct rmap_path_counting *context)
{
    rmap_column_set columns =
        rmap_path_keys_columns(context->keys) | RMAP_COLUMN_BIT(RMAP_RAY_weight);
    return context->most_cells ? columns | RMAP_COLUMN_BIT(RMAP_REGISTRATION_cell) : columns;
}

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
    rmap_key_sums_fini(&self->classes);
    rmap_key_sums_fini(&self->cells);
    rmap_path_steps_fini(&self->steps);
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
    rmap_key_sums_init(&self->classes, context->most_classes);
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
    self->cells.n = self->cells.n_slot = 0;
}

/* More classes than may be: from now on there is the sketch alone. */
enum rmap_status rmap_path_counts_spill(struct rmap_path_counts *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (self->is_full)
        return RMAP_OK;
    if (!self->context->sketch) {
        RMAP_TRY(rmap_path_sketch_init(&self->sketch, err));
        for (size_t i = 0; i < self->classes.n; i++) {
            const struct rmap_key_sum *sum = &self->classes.entry[i];
            rmap_path_sketch_add(&self->sketch, sum->key, sum->number[RMAP_PATH_RAYS]);
        }
    }
    self->is_full = self->steps.is_closed = self->steps.is_full = true;
    rmap_key_sums_fini(&self->classes);
    rmap_path_steps_fini(&self->steps);
    rmap_path_counts_drop_cells(self);
out:
    return st;
}

static inline void add_to(struct rmap_key_sum *sum, const struct rmap_key_sum *more)
{
    uint64_t *number = sum->number;
    if (number[RMAP_PATH_RAYS] == 0 ||
        more->number[RMAP_PATH_FIRST_RAY] < number[RMAP_PATH_FIRST_RAY])
        number[RMAP_PATH_FIRST_RAY] = more->number[RMAP_PATH_FIRST_RAY];
    for (int k = RMAP_PATH_RAYS; k <= RMAP_PATH_REGISTRATIONS; k++)
        number[k] += more->number[k];
    sum->weight += more->weight;
    sum->weight_squared += more->weight_squared;
}

/* Adds what another entry, or one ray, brings to its class. */
enum rmap_status rmap_path_counts_add_class(struct rmap_path_counts *self,
                                            const struct rmap_key_sum *more,
                                            struct rmap_path_added *added, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_key_sum *sum = NULL;
    if (!self->is_full) {
        RMAP_TRY(rmap_key_sums_enter(&self->classes, more->key, &sum, err));
        if (!sum)
            RMAP_TRY(rmap_path_counts_spill(self, err));
    }
    *added = (struct rmap_path_added){sum, sum ? sum->number[RMAP_PATH_RAYS] : 0};
    if (sum)
        add_to(sum, more);
    else if (self->sketch.rays)
        rmap_path_sketch_add(&self->sketch, more->key, more->number[RMAP_PATH_RAYS]);
out:
    return st;
}

/* Numbers of a cell's entry: the last ray, and what it brought so far in weights. */
enum { LAST_RAY, LAST_COUNT };

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

static void add_totals(struct rmap_path_counts *self, const struct rmap_portion *portion)
{
    const struct rmap_path_buffers *buffers = self->buffers;
    uint64_t n_segment = 0;
    for (size_t i = 0; i < buffers->n_ray; i++)
        n_segment += portion->ray.segment_count[buffers->ray[i].place.ray];
    self->total.rays += buffers->n_ray;
    self->total.segments += n_segment;
    if (rmap_weights_are_one(portion->ray.weight, portion->n_row[RMAP_TABLE_RAY]))
        add_ones(self, portion);
    else
        add_weights(self, portion);
}

enum rmap_status rmap_path_counts_make_room(struct rmap_path_counts *self,
                                            const struct rmap_portion *portion,
                                            const struct rmap_path_place_of_ray *place,
                                            const struct rmap_path_added *added,
                                            rmap_path_step **to, struct rmap_error *err)
{
    const size_t most = (size_t)portion->ray.segment_count[place->ray] +
                        portion->ray.registration_count[place->ray];
    return rmap_path_steps_make_room(&self->steps, most, added->sum->number[RMAP_PATH_RAYS], to,
                                     err);
}

void rmap_path_counts_end_class(struct rmap_path_counts *self, const struct rmap_path_added *added,
                                size_t n)
{
    rmap_path_steps_end_class(&self->steps, (size_t)(added->sum - self->classes.entry), n);
}

/* By a ray of the portion in hand. */
static enum rmap_status keep_steps(struct rmap_path_counts *self,
                                   const struct rmap_portion *portion,
                                   const struct rmap_path_place_of_ray *place,
                                   const struct rmap_path_added *added, struct rmap_error *err)
{
    rmap_path_step *to;
    enum rmap_status st = rmap_path_counts_make_room(self, portion, place, added, &to, err);
    if (to)
        rmap_path_counts_end_class(self, added,
                                   rmap_path_hasher_steps(&self->buffers->hasher, place, to));
    return st;
}

static inline enum rmap_status add_ray(struct rmap_path_counts *self,
                                       const struct rmap_portion *portion,
                                       const struct rmap_path_of_ray *its, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_ray_columns *ray = &portion->ray;
    const size_t row = its->place.ray;
    const double weight = ray->weight[row];
    struct rmap_path_added added;
    struct rmap_key_sum one = {.key = its->key,
                               .weight = weight,
                               .weight_squared = weight * weight,
                               .number = {[RMAP_PATH_RAYS] = 1,
                                          [RMAP_PATH_SEGMENTS] = ray->segment_count[row],
                                          [RMAP_PATH_FIRST_RAY] = ray->id[row]}};
    if (ray->registration_count[row] > 0)
        RMAP_TRY(add_hits(self, portion, its, &one.number[RMAP_PATH_REGISTRATIONS], err));
    RMAP_TRY(rmap_path_counts_add_class(self, &one, &added, err));
    if (rmap_path_counts_want_steps(self, &added))
        st = keep_steps(self, portion, &its->place, &added, err);
out:
    return st;
}

static void expect(const struct rmap_path_counts *self, struct rmap_key key)
{
    if (self->sketch.rays)
        rmap_path_sketch_expect(&self->sketch, key);
    else if (self->context->sketch)
        rmap_path_sketch_expect(self->context->sketch, key);
    else
        rmap_key_sums_expect(&self->classes, key);
}

static enum rmap_status reserve(struct rmap_path_buffers *buffers, size_t n, struct rmap_error *err)
{
    void *block = buffers->ray;
    enum rmap_status st = rmap_reserve(&block, &buffers->ray_cap, n + 1, sizeof *buffers->ray, err);
    buffers->ray = block;
    return st;
}

/* Whether a ray's key alone says what it is added to. */
static bool is_plain(const struct rmap_path_counts *self)
{
    const struct rmap_path_counting *context = self->context;
    return !self->is_full && !context->chosen && !context->sketch && context->detector < 0 &&
           (context->most_cells == 0 || self->cells_full);
}

/* What a ray brings to its class. */
static inline void add_one(struct rmap_key_sum *sum, const struct rmap_ray_columns *ray,
                           const struct rmap_path_of_ray *its)
{
    const size_t row = its->place.ray;
    const double weight = ray->weight[row];
    const uint64_t id = ray->id[row], first = sum->number[RMAP_PATH_FIRST_RAY];
    const bool is_first = sum->number[RMAP_PATH_RAYS] == 0 || id < first;
    sum->number[RMAP_PATH_FIRST_RAY] = is_first ? id : first;
    sum->number[RMAP_PATH_RAYS]++;
    sum->number[RMAP_PATH_SEGMENTS] += ray->segment_count[row];
    sum->number[RMAP_PATH_REGISTRATIONS] += its->n_hit;
    sum->weight += weight;
    sum->weight_squared += weight * weight;
}

/* Keys of up to TOGETHER rays are mixed, and their slots expected; returns how many. */
static inline size_t expect_some(const struct rmap_key_sums *classes,
                                 const struct rmap_path_of_ray *list, size_t n,
                                 uint64_t mixed[RMAP_PATH_TOGETHER])
{
    n = n < RMAP_PATH_TOGETHER ? n : RMAP_PATH_TOGETHER;
    for (size_t k = 0; k < n; k++)
        mixed[k] = rmap_key_sums_mixed(list[k].key);
    rmap_key_sums_expect_slots(classes, mixed, n);
    return n;
}

/* *n_ret: how many were added: all, unless there are more classes than may be. */
static enum rmap_status add_plain(struct rmap_path_counts *self, const struct rmap_portion *portion,
                                  size_t *n_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_of_ray *list = self->buffers->ray;
    const size_t n = self->buffers->n_ray;
    struct rmap_key_sums *classes = &self->classes;
    uint64_t mixed[2][RMAP_PATH_TOGETHER];
    size_t first = 0, i = 0, some = expect_some(classes, list, n, mixed[0]);
    for (int turn = 0; some > 0; turn ^= 1) {
        const size_t behind = first + some;
        rmap_key_sums_expect_entries(classes, mixed[turn], some);
        some = expect_some(classes, list + behind, n - behind, mixed[turn ^ 1]);
        for (; i < behind; i++) {
            struct rmap_key_sum *sum;
            RMAP_TRY(
                rmap_key_sums_enter_mixed(classes, list[i].key, mixed[turn][i - first], &sum, err));
            if (!sum)
                goto out;
            const struct rmap_path_added added = {sum, sum->number[RMAP_PATH_RAYS]};
            add_one(sum, &portion->ray, &list[i]);
            if (rmap_path_counts_want_steps(self, &added))
                RMAP_TRY(keep_steps(self, portion, &list[i].place, &added, err));
        }
        first = behind;
    }
out:
    *n_ret = i;
    return st;
}

static enum rmap_status add_rays(struct rmap_path_counts *self, const struct rmap_matched *rays,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_buffers *buffers = self->buffers;
    RMAP_TRY(rmap_fold_fetch(
        rays, rmap_path_count_columns(self->context) & ~RMAP_PATH_HASH_DEFERRED, err));
    RMAP_TRY(reserve(buffers, rays->n_match, err));
    RMAP_TRY(rmap_path_hasher_enter(&buffers->hasher, self->context->keys, rays, err));
    buffers->n_ray = rmap_path_hasher_list(&buffers->hasher, rays, buffers->ray);
    add_totals(self, rays->portion);
    size_t i = 0;
    if (is_plain(self))
        RMAP_TRY(add_plain(self, rays->portion, &i, err));
    for (; i < buffers->n_ray; i++) {
        if (i + RMAP_PATH_AHEAD < buffers->n_ray)
            expect(self, buffers->ray[i + RMAP_PATH_AHEAD].key);
        if (rmap_path_counts_has(self->context, buffers->ray[i].key))
            RMAP_TRY(add_ray(self, rays->portion, &buffers->ray[i], err));
    }
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
                                                    .pack = rmap_path_counts_pack,
                                                    .unpack = rmap_path_counts_unpack};
