/* SPDX-License-Identifier: MIT */
#include "analysis/path_count.h"

#include <inttypes.h>
#include <string.h>

#include "base/alloc.h"

/* Of a portion's rays that count, what is added once all keys are known: by then the lines of the
 * tables that are needed are on their way from memory. */
struct entry {
    struct rmap_key key;
    struct rmap_path_place_of_ray place;
};

struct rmap_path_buffers {
    struct entry *entry;
    size_t n_entry, entry_cap;
};

/* As many entries ahead as memory takes to answer. */
enum { AHEAD = 12, SOURCE_BITS = 20 };

struct rmap_key rmap_path_class_key(int32_t source, struct rmap_path_hash hash)
{
    /* Sources are told apart in either half: the sketch takes bits of both. */
    uint64_t low = hash.low + ((uint64_t)(uint32_t)source + 1) * UINT64_C(0x9e3779b97f4a7c15);
    return (struct rmap_key){low, UINT64_C(1) << 63 | hash.high << SOURCE_BITS |
                                      (uint64_t)(uint32_t)source};
}

int32_t rmap_path_source_of(struct rmap_key key)
{
    return (int32_t)(key.high & (RMAP_PATH_SOURCES_MAX - 1));
}

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
    if (self->buffers)
        rmap_free(self->buffers->entry);
    rmap_free(self->buffers);
    rmap_key_sums_fini(&self->classes);
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
    rmap_key_sums_init(&self->classes, context->most_classes);
    rmap_key_sums_init(&self->cells, context->most_cells);
    RMAP_TRY(rmap_count_init(&self->total, rmap_map_scene(context->map)->n_source, err));
    *state_ret = self;
    self = NULL;
out:
    destroy(self);
    return st;
}

static void drop_cells(struct rmap_path_counts *self)
{
    self->cells_full = true;
    rmap_key_sums_fini(&self->cells);
    self->cells.n = self->cells.n_slot = 0;
}

/* More classes than may be: from now on there is the sketch alone. */
static enum rmap_status spill(struct rmap_path_counts *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (self->is_full)
        return RMAP_OK;
    if (!self->context->sketch) {
        RMAP_TRY(rmap_path_sketch_init(&self->sketch, err));
        for (size_t i = 0; i < self->classes.n_slot; i++)
            if (self->classes.slot[i].key.high != 0)
                rmap_path_sketch_add(&self->sketch, self->classes.slot[i].key,
                                     self->classes.slot[i].number[RMAP_PATH_RAYS]);
    }
    self->is_full = true;
    rmap_key_sums_fini(&self->classes);
    drop_cells(self);
out:
    return st;
}

/* Adds what another entry, or one ray, brings to its class. */
static enum rmap_status add_class(struct rmap_path_counts *self, const struct rmap_key_sum *more,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_key_sum *sum = NULL;
    if (!self->is_full) {
        RMAP_TRY(rmap_key_sums_enter(&self->classes, more->key, &sum, err));
        if (!sum)
            RMAP_TRY(spill(self, err));
    }
    if (!sum) {
        if (self->sketch.rays)
            rmap_path_sketch_add(&self->sketch, more->key, more->number[RMAP_PATH_RAYS]);
        goto out;
    }
    uint64_t *number = sum->number;
    if (number[RMAP_PATH_RAYS] == 0 ||
        more->number[RMAP_PATH_FIRST_RAY] < number[RMAP_PATH_FIRST_RAY])
        number[RMAP_PATH_FIRST_RAY] = more->number[RMAP_PATH_FIRST_RAY];
    for (int k = RMAP_PATH_RAYS; k <= RMAP_PATH_REGISTRATIONS; k++)
        number[k] += more->number[k];
    sum->weight += more->weight;
    sum->weight_squared += more->weight_squared;
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
        drop_cells(self);
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
                                 const struct entry *entry, uint64_t *n_hit, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_counting *context = self->context;
    const struct rmap_detector *detector =
        rmap_scene_with(context->map, context->overlay)->detector;
    const struct rmap_registration_columns *hit = &portion->registration;
    size_t first = entry->place.registration;
    size_t last = first + portion->ray.registration_count[entry->place.ray];
    *n_hit = 0;
    for (size_t i = first; i < last; i++) {
        int32_t d = hit->detector[i];
        if (!hit->registered[i] || (context->detector >= 0 && d != context->detector))
            continue;
        ++*n_hit;
        if (self->cells_full || context->most_cells == 0)
            continue;
        uint32_t cell = hit->cell[2 * i] + hit->cell[2 * i + 1] * detector[d].cells[0];
        RMAP_TRY(add_cell(self, cell_key(entry->key, d, cell), portion->ray.id[entry->place.ray],
                          portion->ray.weight[entry->place.ray], err));
    }
out:
    return st;
}

static bool counts(const struct rmap_path_counting *context, struct rmap_key key)
{
    if (context->chosen && !rmap_key_sums_find(context->chosen, key))
        return false;
    return !context->sketch || rmap_path_sketch_estimate(context->sketch, key) >=
                                   context->least[rmap_path_source_of(key)];
}

static enum rmap_status add_ray(struct rmap_path_counts *self, const struct rmap_portion *portion,
                                const struct entry *entry, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t ray = entry->place.ray;
    const double weight = portion->ray.weight[ray];
    struct rmap_key_sum one = {.key = entry->key,
                               .weight = weight,
                               .weight_squared = weight * weight,
                               .number = {[RMAP_PATH_RAYS] = 1,
                                          [RMAP_PATH_SEGMENTS] = portion->ray.segment_count[ray],
                                          [RMAP_PATH_FIRST_RAY] = portion->ray.id[ray]}};
    const size_t source = (size_t)portion->ray.source[ray];
    self->total.rays++;
    self->total.segments += one.number[RMAP_PATH_SEGMENTS];
    self->total.source_weight[source] += weight;
    self->total.source_weight_squared[source] += weight * weight;
    self->most_weight = weight > self->most_weight ? weight : self->most_weight;
    if (!counts(self->context, entry->key))
        return RMAP_OK;
    RMAP_TRY(add_hits(self, portion, entry, &one.number[RMAP_PATH_REGISTRATIONS], err));
    st = add_class(self, &one, err);
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

static enum rmap_status reserve(struct rmap_path_buffers *buffers,
                                const struct rmap_portion *portion, struct rmap_error *err)
{
    void *entry = buffers->entry;
    enum rmap_status st =
        rmap_reserve(&entry, &buffers->entry_cap, portion->n_row[RMAP_TABLE_RAY] + 1,
                     sizeof *buffers->entry, err);
    buffers->entry = entry;
    return st;
}

/* The keys of the rays that match and have a path. */
static void find_entries(const struct rmap_path_counting *context,
                         struct rmap_path_buffers *buffers, const struct rmap_matched *rays)
{
    const struct rmap_portion *portion = rays->portion;
    struct rmap_path_place_of_ray place = {0};
    buffers->n_entry = 0;
    for (; place.ray < portion->n_row[RMAP_TABLE_RAY]; place.ray++) {
        struct rmap_path_hash hash;
        if ((!rays->match || rays->match[place.ray]) &&
            rmap_path_key_hash(context->keys, portion, &place, &hash))
            buffers->entry[buffers->n_entry++] =
                (struct entry){rmap_path_class_key(portion->ray.source[place.ray], hash), place};
        place.segment += portion->ray.segment_count[place.ray];
        place.registration += portion->ray.registration_count[place.ray];
    }
}

static enum rmap_status add(void *state, const struct rmap_matched *rays, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_counts *self = state;
    struct rmap_path_buffers *buffers = self->buffers;
    RMAP_TRY(reserve(buffers, rays->portion, err));
    find_entries(self->context, buffers, rays);
    for (size_t i = 0; i < buffers->n_entry; i++) {
        if (i + AHEAD < buffers->n_entry)
            expect(self, buffers->entry[i + AHEAD].key);
        RMAP_TRY(add_ray(self, rays->portion, &buffers->entry[i], err));
    }
out:
    return st;
}

static enum rmap_status merge_classes(struct rmap_path_counts *into,
                                      const struct rmap_path_counts *from, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (from->is_full)
        RMAP_TRY(spill(into, err));
    for (size_t i = 0; i < from->classes.n_slot; i++)
        if (from->classes.slot[i].key.high != 0)
            RMAP_TRY(add_class(into, &from->classes.slot[i], err));
    if (from->sketch.rays)
        rmap_path_sketch_merge(&into->sketch, &from->sketch);
out:
    return st;
}

static enum rmap_status merge_cells(struct rmap_path_counts *into,
                                    const struct rmap_path_counts *from, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (from->cells_full)
        drop_cells(into);
    for (size_t i = 0; i < from->cells.n_slot && !into->cells_full; i++) {
        const struct rmap_key_sum *more = &from->cells.slot[i];
        struct rmap_key_sum *sum = NULL;
        if (more->key.high == 0)
            continue;
        RMAP_TRY(rmap_key_sums_enter(&into->cells, more->key, &sum, err));
        if (!sum) {
            drop_cells(into);
            break;
        }
        sum->weight += more->weight;
        sum->weight_squared += more->weight_squared;
    }
out:
    return st;
}

static enum rmap_status merge(void *into_, const void *from_, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_counts *into = into_;
    const struct rmap_path_counts *from = from_;
    rmap_count_add(&into->total, &from->total, rmap_map_scene(into->context->map)->n_source);
    if (from->most_weight > into->most_weight)
        into->most_weight = from->most_weight;
    RMAP_TRY(merge_classes(into, from, err));
    st = merge_cells(into, from, err);
out:
    return st;
}

/* What a state is as bytes: this, weights [2][n_source], classes, cells, and the sketch. */
struct head {
    uint64_t rays, segments, n_class, n_cell;
    double most_weight;
    uint64_t is_full, cells_full, has_sketch;
};

static uint8_t *put(uint8_t *to, const void *from, size_t nbytes)
{
    if (nbytes > 0)
        memcpy(to, from, nbytes);
    return to + nbytes;
}

static uint8_t *put_sums(uint8_t *to, const struct rmap_key_sums *sums)
{
    for (size_t i = 0; i < sums->n_slot; i++)
        if (sums->slot[i].key.high != 0)
            to = put(to, &sums->slot[i], sizeof sums->slot[i]);
    return to;
}

static size_t state_nbytes(const struct head *head, size_t n_source)
{
    return sizeof *head + 2 * n_source * sizeof(double) +
           (size_t)(head->n_class + head->n_cell) * sizeof(struct rmap_key_sum) +
           (head->has_sketch ? RMAP_PATH_SKETCH_NBYTES : 0);
}

static enum rmap_status pack(const void *state, uint8_t **bytes_ret, size_t *nbytes_ret,
                             struct rmap_error *err)
{
    const struct rmap_path_counts *self = state;
    const size_t n_source = rmap_map_scene(self->context->map)->n_source;
    const struct head head = {self->total.rays, self->total.segments,     self->classes.n,
                              self->cells.n,    self->most_weight,        self->is_full,
                              self->cells_full, self->sketch.rays != NULL};
    const size_t nbytes = state_nbytes(&head, n_source);
    uint8_t *bytes = rmap_alloc(nbytes, 1), *at = bytes;
    if (!bytes)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the paths of a rank");
    at = put(at, &head, sizeof head);
    at = put(at, self->total.source_weight, n_source * sizeof(double));
    at = put(at, self->total.source_weight_squared, n_source * sizeof(double));
    at = put_sums(at, &self->classes);
    at = put_sums(at, &self->cells);
    if (head.has_sketch)
        (void)put(at, self->sketch.rays, RMAP_PATH_SKETCH_NBYTES);
    *bytes_ret = bytes;
    *nbytes_ret = nbytes;
    return RMAP_OK;
}

static enum rmap_status take_sums(struct rmap_key_sums *sums, const uint8_t **at, uint64_t n,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (uint64_t i = 0; i < n; i++) {
        struct rmap_key_sum sum, *entry = NULL;
        memcpy(&sum, *at, sizeof sum);
        *at += sizeof sum;
        RMAP_TRY(rmap_key_sums_enter(sums, sum.key, &entry, err));
        if (entry)
            *entry = sum;
    }
out:
    return st;
}

static enum rmap_status unpack(const void *context_, const uint8_t *bytes, size_t nbytes,
                               void **state_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_counting *context = context_;
    const size_t n_source = rmap_map_scene(context->map)->n_source;
    struct head head = {0};
    struct rmap_path_counts *self = NULL;
    void *state = NULL;
    if (nbytes >= sizeof head)
        memcpy(&head, bytes, sizeof head);
    if (nbytes < sizeof head || nbytes != state_nbytes(&head, n_source))
        return rmap_error_set(err, RMAP_INTERNAL, "paths of a rank: %zu bytes came", nbytes);
    RMAP_TRY(create(context, &state, err));
    self = state;
    self->total.rays = head.rays;
    self->total.segments = head.segments;
    self->most_weight = head.most_weight;
    self->is_full = head.is_full != 0;
    self->cells_full = head.cells_full != 0;
    const uint8_t *at = bytes + sizeof head;
    memcpy(self->total.source_weight, at, n_source * sizeof(double));
    at += n_source * sizeof(double);
    memcpy(self->total.source_weight_squared, at, n_source * sizeof(double));
    at += n_source * sizeof(double);
    RMAP_TRY(take_sums(&self->classes, &at, head.n_class, err));
    RMAP_TRY(take_sums(&self->cells, &at, head.n_cell, err));
    if (head.has_sketch) {
        RMAP_TRY(rmap_path_sketch_init(&self->sketch, err));
        memcpy(self->sketch.rays, at, RMAP_PATH_SKETCH_NBYTES);
    }
    *state_ret = self;
    self = NULL;
out:
    destroy(self);
    return st;
}

const struct rmap_fold_kind rmap_path_count_kind = {.create = create,
                                                    .destroy = destroy,
                                                    .add = add,
                                                    .merge = merge,
                                                    .pack = pack,
                                                    .unpack = unpack};
