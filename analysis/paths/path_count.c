/* SPDX-License-Identifier: MIT
 *
 * Rays go to their classes one by one; those that share a path together (path_count.c).
 */
#include <math.h>
#include <string.h>

#include "analysis/paths/path_count.h"
#include "base/alloc.h"
#include "portion/weight.h"

static enum rmap_status path_counts_add_summary(struct rmap_path_counts *counts,
                                                const struct rmap_matched *rays,
                                                const struct rmap_path_summary *summary,
                                                bool *done_ret,
                                                struct rmap_error *err) RMAP_MUST_USE;

rmap_column_set rmap_path_count_columns(const struct rmap_path_counting *context)
{
    rmap_column_set columns =
        rmap_path_keys_columns(context->keys) | RMAP_COLUMN_BIT(RMAP_RAY_weight);
    if (context->timed && rmap_path_keys_view(context->keys)->until_detector)
        columns |= RMAP_COLUMN_BIT(RMAP_REGISTRATION_group_path) |
                   RMAP_COLUMN_BIT(RMAP_REGISTRATION_delay);
    else if (context->timed)
        columns |= RMAP_COLUMN_BIT(RMAP_RAY_group_path) | RMAP_COLUMN_BIT(RMAP_RAY_delay);
    return context->most_cells ? columns | RMAP_COLUMN_BIT(RMAP_REGISTRATION_cell) : columns;
}

static void destroy(void *state)
{
    struct rmap_path_counts *self = state;
    if (!self)
        return;
    rmap_path_dictionary_fini(&self->dictionary);
    rmap_free(self->step);
    rmap_free(self->of_ray);
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
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for paths");
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

/* ---- classes ---- */

static void drop_cells(struct rmap_path_counts *self)
{
    self->cells_full = true;
    rmap_key_sums_fini(&self->cells);
}

/* More classes than may be: from now on there is the sketch alone. */
static enum rmap_status spill(struct rmap_path_counts *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (self->is_full)
        return RMAP_OK;
    if (!self->context->sketch) {
        RMAP_TRY(rmap_path_sketch_init(&self->sketch, err));
        for (size_t i = 0; i < self->classes.n; i++)
            rmap_path_sketch_add(&self->sketch, self->classes.entry[i].key,
                                 self->classes.entry[i].number[RMAP_PATH_CLASS_RAYS]);
    }
    self->is_full = true;
    rmap_key_sums_fini(&self->classes);
    drop_cells(self);
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

/* ---- times ---- */

/* Unit of weight x time: 2^-20 ns. */
static const double TIME_UNIT = 1.0 / (1 << 20), MOST_TIME = 9e18;

/* Of one path of a ray of that weight. */
static void set_time(const struct rmap_path_counts *self, const struct rmap_portion *portion,
                     const struct rmap_path_place_of_ray *place, struct rmap_key_sum *one)
{
    const struct rmap_scene *scene = rmap_map_scene(self->context->map);
    const double ns = scene->unit_m / 0.299792458; /* per length */
    const size_t row = place->until - (place->until > 0);
    const double time =
        place->until ? portion->registration.delay[row] + ns * portion->registration.group_path[row]
                     : portion->ray.delay[place->ray] + ns * portion->ray.group_path[place->ray];
    const double units = rint(one->weight * time / TIME_UNIT);
    const int64_t whole = (int64_t)fmin(fmax(units, -MOST_TIME), MOST_TIME);
    one->number[RMAP_PATH_CLASS_TIME] = (uint64_t)whole;
    one->number[RMAP_PATH_CLASS_TIME_HIGH] = whole < 0 ? UINT64_MAX : 0;
}

static void add_time(uint64_t *sum, const uint64_t *more)
{
    sum[0] += more[0];
    sum[1] += more[1] + (sum[0] < more[0]);
}

double rmap_path_class_time(const struct rmap_key_sum *sum)
{
    const uint64_t *time = sum->number + RMAP_PATH_CLASS_TIME;
    const bool negative = time[1] >> 63;
    const uint64_t low = negative ? 0 - time[0] : time[0];
    const uint64_t high = negative ? ~time[1] + (time[0] == 0) : time[1];
    const double size = ldexp((double)high, 64) + (double)low;
    return (negative ? -size : size) * TIME_UNIT / sum->weight;
}

static void add_to(struct rmap_key_sum *sum, const struct rmap_key_sum *more)
{
    const bool is_new = sum->number[RMAP_PATH_CLASS_RAYS] == 0;
    uint64_t *first = &sum->number[RMAP_PATH_CLASS_FIRST_RAY];
    const uint64_t id = more->number[RMAP_PATH_CLASS_FIRST_RAY];
    *first = is_new || id < *first ? id : *first;
    sum->weight += more->weight;
    sum->weight_squared += more->weight_squared;
    sum->number[RMAP_PATH_CLASS_RAYS] += more->number[RMAP_PATH_CLASS_RAYS];
    sum->number[RMAP_PATH_CLASS_SEGMENTS] += more->number[RMAP_PATH_CLASS_SEGMENTS];
    sum->number[RMAP_PATH_CLASS_REGISTRATIONS] += more->number[RMAP_PATH_CLASS_REGISTRATIONS];
    add_time(sum->number + RMAP_PATH_CLASS_TIME, more->number + RMAP_PATH_CLASS_TIME);
}

/* Of one that counts. */
static enum rmap_status add_counted(struct rmap_path_counts *self, const struct rmap_key_sum *more,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_key_sum *sum = NULL;
    if (!self->is_full) {
        RMAP_TRY(rmap_key_sums_enter(&self->classes, more->key, &sum, err));
        if (sum)
            add_to(sum, more);
        else
            RMAP_TRY(spill(self, err));
    }
    if (!sum && self->sketch.rays)
        rmap_path_sketch_add(&self->sketch, more->key, more->number[RMAP_PATH_CLASS_RAYS]);
out:
    return st;
}

/* Adds what rays of weight 1, or one ray, bring to their class, unless it is none of those that
 * count. more: the key, weights and numbers. */
static enum rmap_status path_counts_add_class(struct rmap_path_counts *self,
                                              const struct rmap_key_sum *more,
                                              struct rmap_error *err)
{
    return counts(self->context, more->key) ? add_counted(self, more, err) : RMAP_OK;
}

/* ---- cells ---- */

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
        drop_cells(self);
        goto out;
    }
    bool again = sum->number[LAST_COUNT] > 0 && sum->number[LAST_RAY] == ray;
    uint64_t k = again ? sum->number[LAST_COUNT] + 1 : 1;
    sum->number[LAST_RAY] = ray;
    sum->number[LAST_COUNT] = k;
    sum->weight += weight;
    sum->weight_squared += (2.0 * (double)k - 1.0) * rmap_weight_squared(weight);
out:
    return st;
}

/* Registrations of a path that count: how many, and each in its cell. */
static enum rmap_status add_hits(struct rmap_path_counts *self, const struct rmap_portion *portion,
                                 const struct rmap_path_place_of_ray *place, struct rmap_key key,
                                 uint64_t *n_hit, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_counting *context = self->context;
    const struct rmap_detector *detector =
        rmap_scene_with(context->map, context->overlay)->detector;
    const struct rmap_registration_columns *hit = &portion->registration;
    const size_t first = place->until ? place->until - 1 : place->registration;
    const size_t last = place->until
                            ? place->until
                            : place->registration + portion->ray.registration_count[place->ray];
    *n_hit = 0;
    for (size_t i = first; i < last; i++) {
        const int32_t d = hit->detector[i];
        if (!hit->registered[i] || (context->detector >= 0 && d != context->detector))
            continue;
        ++*n_hit;
        if (self->cells_full || context->most_cells == 0)
            continue;
        const uint32_t cell = hit->cell[2 * i] + hit->cell[2 * i + 1] * detector[d].cells[0];
        RMAP_TRY(add_cell(self, cell_key(key, d, cell), portion->ray.id[place->ray],
                          portion->ray.weight[place->ray], err));
    }
out:
    return st;
}

/* ---- rays ---- */

/* A path of a ray, of which *n_path were added before. The n-th time that it comes to a class adds
 * (n w)^2 - ((n - 1) w)^2: a ray is one contribution. */
static enum rmap_status add_path(struct rmap_path_counts *self, const struct rmap_portion *portion,
                                 const struct rmap_path_place_of_ray *place, size_t *n_path,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_ray_columns *ray = &portion->ray;
    const uint64_t n_segment = ray->segment_count[place->ray];
    const double weight = ray->weight[place->ray];
    size_t n_step, before = 0;
    if (!rmap_path_key_of(self->context->keys, portion, place, self->step, &n_step))
        return RMAP_OK;
    const struct rmap_key key = rmap_path_key_hash(self->step, n_step, ray->source[place->ray]);
    for (size_t i = 0; i < *n_path; i++)
        before += rmap_keys_equal(self->of_ray[i], key);
    if (*n_path > 0 && before == 0) {
        self->again.rays++;
        self->again.segments += n_segment;
    }
    RMAP_TRY(RMAP_RESERVE(self->of_ray, self->of_ray_cap, *n_path + 1, err));
    self->of_ray[(*n_path)++] = key;
    if (!counts(self->context, key))
        goto out;
    struct rmap_key_sum one = {key,
                               weight,
                               (2.0 * (double)before + 1.0) * rmap_weight_squared(weight),
                               {before == 0, ray->id[place->ray], before == 0 ? n_segment : 0, 0}};
    if (self->context->timed)
        set_time(self, portion, place, &one);
    RMAP_TRY(add_hits(self, portion, place, key, &one.number[RMAP_PATH_CLASS_REGISTRATIONS], err));
    st = add_counted(self, &one, err);
out:
    return st;
}

static void add_total(struct rmap_path_counts *self, const struct rmap_portion *portion, size_t ray,
                      size_t n_path)
{
    const size_t source = (size_t)portion->ray.source[ray];
    const double weight = portion->ray.weight[ray] * (double)n_path;
    self->total.rays++;
    self->total.segments += portion->ray.segment_count[ray];
    self->total.source_weight[source] += weight;
    self->total.source_weight_squared[source] += rmap_weight_squared(weight);
    self->most_weight = weight > self->most_weight ? weight : self->most_weight;
}

/* All paths of a ray: one, or one for each of its registrations that are to end one. */
static enum rmap_status add_ray(struct rmap_path_counts *self, const struct rmap_portion *portion,
                                struct rmap_path_place_of_ray place, const uint8_t *counted,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_view *view = rmap_path_keys_view(self->context->keys);
    const size_t n_hit = portion->ray.registration_count[place.ray];
    size_t n_path = 0;
    RMAP_TRY(RMAP_RESERVE(self->step, self->step_cap,
                          (size_t)portion->ray.segment_count[place.ray] + n_hit + 1, err));
    if (!view->until_detector)
        RMAP_TRY(add_path(self, portion, &place, &n_path, err));
    for (size_t i = place.registration; view->until_detector && i < place.registration + n_hit;
         i++) {
        place.until = i + 1;
        if (counted[i] && portion->registration.detector[i] == view->detector)
            RMAP_TRY(add_path(self, portion, &place, &n_path, err));
    }
    if (n_path > 0)
        add_total(self, portion, place.ray, n_path);
out:
    return st;
}

/* Adds the rays of a portion that has the columns, one by one. */
static enum rmap_status path_counts_add_rays(struct rmap_path_counts *self,
                                             const struct rmap_matched *rays,
                                             struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *portion = rays->portion;
    struct rmap_path_place_of_ray place = {0};
    RMAP_TRY(rmap_fold_fetch(rays, rmap_path_count_columns(self->context), err));
    for (; place.ray < portion->n_row[RMAP_TABLE_RAY]; place.ray++) {
        if (!rays->match || rays->match[place.ray])
            RMAP_TRY(add_ray(self, portion, place, rmap_registrations_counted(rays), err));
        place.segment += portion->ray.segment_count[place.ray];
        place.registration += portion->ray.registration_count[place.ray];
    }
out:
    return st;
}

/* ---- a kind of fold ---- */

static enum rmap_status add(void *state, const struct rmap_matched *rays, struct rmap_error *err)
{
    struct rmap_path_counts *self = state;
    const bool cells = self->context->most_cells > 0 && !self->cells_full;
    struct rmap_path_summary summary = {.paths = NULL};
    enum rmap_status st = RMAP_OK;
    bool done = false;
    if (!cells && !self->context->timed) /* times are each ray's own */
        RMAP_TRY(rmap_fold_path_summary(rays, &summary, err));
    if (rmap_path_shares_matter(rays, &summary))
        RMAP_TRY(path_counts_add_summary(self, rays, &summary, &done, err));
    if (!done)
        st = path_counts_add_rays(self, rays, err);
out:
    return st;
}

static enum rmap_status merge_cells(struct rmap_path_counts *into,
                                    const struct rmap_path_counts *from, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (from->cells_full)
        drop_cells(into);
    for (size_t i = 0; i < from->cells.n && !into->cells_full; i++) {
        const struct rmap_key_sum *more = &from->cells.entry[i];
        struct rmap_key_sum *sum = NULL;
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

static enum rmap_status merge(void *into_, void *from_, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_counts *into = into_;
    const struct rmap_path_counts *from = from_;
    rmap_count_add(&into->total, &from->total, rmap_map_scene(into->context->map)->n_source);
    into->again.rays += from->again.rays;
    into->again.segments += from->again.segments;
    if (from->most_weight > into->most_weight)
        into->most_weight = from->most_weight;
    if (from->is_full)
        RMAP_TRY(spill(into, err));
    for (size_t i = 0; i < from->classes.n; i++)
        RMAP_TRY(add_counted(into, &from->classes.entry[i], err));
    if (from->sketch.rays)
        rmap_path_sketch_merge(&into->sketch, &from->sketch);
    st = merge_cells(into, from, err);
out:
    return st;
}

/* What a state is as bytes: this, weights [2][n_source], classes, cells and the sketch. */
struct head {
    uint64_t rays, segments, again_rays, again_segments, n_class, n_cell;
    double most_weight;
    uint64_t is_full, cells_full, has_sketch;
};

static size_t state_nbytes(const struct head *head, size_t n_source)
{
    return sizeof *head + 2 * n_source * sizeof(double) +
           (size_t)(head->n_class + head->n_cell) * sizeof(struct rmap_key_sum) +
           (head->has_sketch ? RMAP_PATH_SKETCH_NBYTES : 0);
}

static uint8_t *put(uint8_t *to, const void *from, size_t nbytes)
{
    if (nbytes > 0)
        memcpy(to, from, nbytes);
    return to + nbytes;
}

static enum rmap_status pack(const void *state, uint8_t **bytes_ret, size_t *nbytes_ret,
                             struct rmap_error *err)
{
    const struct rmap_path_counts *self = state;
    const size_t n_source = rmap_map_scene(self->context->map)->n_source;
    const struct head head = {.rays = self->total.rays,
                              .segments = self->total.segments,
                              .again_rays = self->again.rays,
                              .again_segments = self->again.segments,
                              .n_class = self->classes.n,
                              .n_cell = self->cells.n,
                              .most_weight = self->most_weight,
                              .is_full = self->is_full,
                              .cells_full = self->cells_full,
                              .has_sketch = self->sketch.rays != NULL};
    const size_t nbytes = state_nbytes(&head, n_source);
    uint8_t *bytes = rmap_alloc_unset(nbytes, 1), *at = bytes;
    if (!bytes)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the paths of a rank");
    at = put(at, &head, sizeof head);
    at = put(at, self->total.source_weight, n_source * sizeof(double));
    at = put(at, self->total.source_weight_squared, n_source * sizeof(double));
    at = put(at, self->classes.entry, self->classes.n * sizeof *self->classes.entry);
    at = put(at, self->cells.entry, self->cells.n * sizeof *self->cells.entry);
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
    void *state = NULL;
    if (nbytes >= sizeof head)
        memcpy(&head, bytes, sizeof head);
    if (nbytes < sizeof head || nbytes != state_nbytes(&head, n_source))
        return rmap_error_set(err, RMAP_INTERNAL, "paths of a rank: %zu bytes came", nbytes);
    RMAP_TRY(create(context, &state, err));
    struct rmap_path_counts *self = state;
    self->total.rays = head.rays;
    self->total.segments = head.segments;
    self->again.rays = head.again_rays;
    self->again.segments = head.again_segments;
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
    *state_ret = state;
    state = NULL;
out:
    destroy(state);
    return st;
}

const struct rmap_fold_kind rmap_path_count_kind = {.create = create,
                                                    .destroy = destroy,
                                                    .add = add,
                                                    .merge = merge,
                                                    .pack = pack,
                                                    .unpack = unpack};

/* Classes by the paths that rays share, as a compact piece has them: path by path, not ray by ray.
 */

/* Rays of the k-th path of the portion, which weigh 1. */
static enum rmap_status add_shared(struct rmap_path_counts *self, size_t k, struct rmap_error *err)
{
    const struct rmap_path_dictionary *dictionary = &self->dictionary;
    const size_t row = dictionary->row[k];
    const struct rmap_path_known *path = &dictionary->known[row];
    const uint64_t n = dictionary->shares.n_ray[k];
    if (n == 0 || path->key.high == 0)
        return RMAP_OK;
    const size_t source = (size_t)rmap_path_source_of(path->key);
    const struct rmap_key_sum some = {path->key,
                                      (double)n,
                                      (double)n,
                                      {n, dictionary->shares.first[k],
                                       n * dictionary->paths->ray.segment_count[row],
                                       n * path->n_hit}};
    self->total.rays += n;
    self->total.segments += some.number[RMAP_PATH_CLASS_SEGMENTS];
    self->total.source_weight[source] += some.weight;
    self->total.source_weight_squared[source] += some.weight_squared;
    self->most_weight = self->most_weight > 1.0 ? self->most_weight : 1.0;
    return path_counts_add_class(self, &some, err);
}

static enum rmap_status add_paths(struct rmap_path_counts *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t k = 0; k < self->dictionary.n && st == RMAP_OK; k++)
        st = add_shared(self, k, err);
    return st;
}

/* Some rays of the portion have several paths, of which a dictionary knows nothing. */
static bool has_several(const struct rmap_path_counts *self)
{
    const struct rmap_path_dictionary *dictionary = &self->dictionary;
    if (!rmap_path_keys_view(self->context->keys)->until_detector)
        return false;
    for (size_t k = 0; k < dictionary->n; k++)
        if (dictionary->shares.n_ray[k] > 0 && dictionary->known[dictionary->row[k]].n_hit > 1)
            return true;
    return false;
}

static struct rmap_path_keying keying_of(const struct rmap_path_counts *self)
{
    const struct rmap_path_counting *context = self->context;
    return (struct rmap_path_keying){context->keys, context->map, context->detector};
}

/* A portion by the paths that its rays share; *done_ret false: rays have several paths each, of
 * which these know nothing. */
static enum rmap_status path_counts_add_summary(struct rmap_path_counts *self,
                                                const struct rmap_matched *rays,
                                                const struct rmap_path_summary *summary,
                                                bool *done_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_keying keying = keying_of(self);
    struct rmap_matched own;
    RMAP_TRY(rmap_path_dictionary_enter_summary(&self->dictionary, &keying, rays, summary, err));
    *done_ret = !has_several(self);
    if (!*done_ret)
        goto out;
    RMAP_TRY(add_paths(self, err));
    RMAP_TRY(rmap_path_shares_own(&self->dictionary.shares, rays, summary, &own, err));
    if (own.n_match > 0)
        st = path_counts_add_rays(self, &own, err);
out:
    return st;
}
