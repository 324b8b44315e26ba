/* SPDX-License-Identifier: MIT */
#include "analysis/path_hash.h"

#include "analysis/path_key_internal.h"
#include "base/alloc.h"

void rmap_path_hasher_fini(struct rmap_path_hasher *hasher)
{
    rmap_free(hasher->few);
    rmap_free(hasher->many);
    rmap_free(hasher->scratch);
    *hasher = (struct rmap_path_hasher){0};
}

enum { SOURCE_BITS = 20 };

bool rmap_path_keys_are_simple(const struct rmap_path_keys *keys)
{
    return !keys->view.collapsed && !keys->view.until_detector;
}

static bool has_few_places(const struct rmap_path_keys *keys)
{
    return 1 + keys->labels.n + keys->scene->n_medium + keys->scene->n_detector <
           (size_t)1 << (16 - RMAP_PATH_LETTER_BITS);
}

static enum rmap_status reserve_steps(struct rmap_path_hasher *hasher, bool few,
                                      struct rmap_error *err)
{
    const size_t n = hasher->portion->n_row[RMAP_TABLE_SEGMENT] + RMAP_STEP_HASH_BEHIND;
    void *block = few ? (void *)hasher->few : (void *)hasher->many;
    enum rmap_status st = rmap_reserve(&block, few ? &hasher->few_cap : &hasher->many_cap, n,
                                       few ? sizeof *hasher->few : sizeof *hasher->many, err);
    if (few)
        hasher->few = block;
    else
        hasher->many = block;
    return st;
}

static enum rmap_status reserve_scratch(struct rmap_path_hasher *hasher, struct rmap_error *err)
{
    const struct rmap_ray_columns *ray = &hasher->portion->ray;
    size_t longest = 0;
    for (size_t i = 0; i < hasher->portion->n_row[RMAP_TABLE_RAY]; i++) {
        const size_t n = (size_t)ray->segment_count[i] + ray->registration_count[i];
        longest = n > longest ? n : longest;
    }
    void *block = hasher->scratch;
    enum rmap_status st =
        rmap_reserve(&block, &hasher->scratch_cap, longest + RMAP_STEP_HASH_BEHIND,
                     sizeof *hasher->scratch, err);
    hasher->scratch = block;
    return st;
}

/* Steps of legs [first, last) by table. False: some without an object need another look. */
static inline bool translate(const struct rmap_path_hasher *hasher, size_t first, size_t last,
                             bool few)
{
    const uint32_t *met = hasher->keys->met, *place = hasher->keys->place + 1;
    const int32_t *object = hasher->portion->segment.object;
    const uint32_t *event = hasher->portion->segment.event;
    uint32_t seen = 0;
    bool inside = false;
    if (few)
        first += rmap_step_letters_steps(&hasher->keys->of_letters, object + first, event + first,
                                         last - first, hasher->few + first, &inside);
    for (size_t i = first; i < last; i++) {
        const uint32_t letter = met[event[i] % RMAP_PATH_EVENT_CODES];
        const uint32_t step = place[object[i]] | letter;
        seen |= letter & (uint32_t)object[i];
        if (few)
            hasher->few[i] = (uint16_t)step;
        else
            hasher->many[i] = step & ~RMAP_PATH_LOOK_TWICE;
    }
    return !inside && !(seen & RMAP_PATH_LOOK_TWICE);
}

static void look_twice(const struct rmap_path_hasher *hasher, size_t first, size_t last, bool few)
{
    const struct rmap_segment_columns *segment = &hasher->portion->segment;
    for (size_t i = first; i < last; i++) {
        if (segment->object[i] >= 0)
            continue;
        const rmap_path_step step = rmap_path_step_of(hasher->keys, segment, i);
        if (few)
            hasher->few[i] = (uint16_t)step;
        else
            hasher->many[i] = step;
    }
}

static enum rmap_status read_steps(struct rmap_path_hasher *hasher, const struct rmap_matched *rays,
                                   size_t first, size_t last, struct rmap_error *err)
{
    const bool few = hasher->is_narrow;
    enum rmap_status st = RMAP_OK;
    if (few ? translate(hasher, first, last, true) : translate(hasher, first, last, false))
        return RMAP_OK;
    if (hasher->keys->reads_media)
        st = rmap_fold_fetch(rays, RMAP_PATH_HASH_DEFERRED, err);
    look_twice(hasher, first, last, few);
    return st;
}

/* Where fewer than one in so many of the rays match, theirs alone: many legs at once cost less than
 * a few, each by itself. */
enum { FEW_RAYS = 4, FEW_RAYS_AT_ONCE = 16 };

enum rmap_status rmap_path_hasher_enter(struct rmap_path_hasher *hasher,
                                        const struct rmap_path_keys *keys,
                                        const struct rmap_matched *rays, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *portion = rays->portion;
    const size_t n_ray = portion->n_row[RMAP_TABLE_RAY];
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        if (portion->n_row[t] > UINT32_MAX)
            return rmap_error_set(err, RMAP_SYSTEM, "a portion of %zu rows has too many for paths",
                                  portion->n_row[t]);
    hasher->keys = keys;
    hasher->portion = portion;
    hasher->is_simple = rmap_path_keys_are_simple(keys);
    hasher->is_narrow = has_few_places(keys);
    if (!hasher->is_simple) {
        if (keys->reads_media)
            RMAP_TRY(rmap_fold_fetch(rays, RMAP_PATH_HASH_DEFERRED, err));
        return reserve_scratch(hasher, err);
    }
    RMAP_TRY(reserve_steps(hasher, hasher->is_narrow, err));
    const size_t few =
        hasher->is_narrow && keys->of_letters.is_usable ? FEW_RAYS_AT_ONCE : FEW_RAYS;
    if (!rays->match || rays->n_match * few >= n_ray)
        return read_steps(hasher, rays, 0, portion->n_row[RMAP_TABLE_SEGMENT], err);
    for (size_t i = 0, first = 0; i < n_ray; i++) {
        const size_t last = first + portion->ray.segment_count[i];
        if (rays->match[i])
            RMAP_TRY(read_steps(hasher, rays, first, last, err));
        first = last;
    }
out:
    return st;
}

static inline uint64_t rotate(uint64_t x, int k)
{
    return x << k | x >> (64 - k);
}

/* Two chains of steps that lose nothing, and nothing joins them before the end. */
static inline void mix(struct rmap_step_hash *hash, uint64_t word)
{
    hash->low = (rotate(hash->low, 27) ^ word) * UINT64_C(0x9e3779b97f4a7c15);
    hash->high = (rotate(hash->high, 41) ^ word) * UINT64_C(0xc2b2ae3d27d4eb4f);
}

/* Upper bits come down: hashes were mixed well before registrations were. */
static inline uint64_t finish(uint64_t x)
{
    x = (x ^ x >> 32) * UINT64_C(0xff51afd7ed558ccd);
    return x ^ x >> 29;
}

/* Registrations stand among the legs: each with its place there. n_hit: its rows; then those of
 * them that are registered. */
static inline void mix_hits(const struct rmap_path_hasher *hasher, struct rmap_path_of_ray *its,
                            uint32_t n_leg, struct rmap_step_hash *hash_ret)
{
    const struct rmap_path_hit *of_detector = hasher->keys->hit;
    const struct rmap_registration_columns *hit = &hasher->portion->registration;
    struct rmap_step_hash hash = *hash_ret;
    const size_t first = its->registration, behind = first + its->n_hit;
    uint64_t at = 0;
    uint32_t n_hit = 0;
    for (size_t i = first; i < behind; i++) {
        if (!hit->registered[i])
            continue;
        const struct rmap_path_hit of = of_detector[hit->detector[i]];
        uint64_t leg = (uint64_t)hit->segment[i] + of.follows;
        leg = leg < n_leg ? leg : n_leg;
        at = leg > at ? leg : at;
        mix(&hash, at << 32 | of.step);
        n_hit++;
    }
    if (n_hit > 0)
        *hash_ret = (struct rmap_step_hash){finish(hash.low), finish(hash.high)};
    its->n_hit = n_hit;
}

static size_t count_hits(const struct rmap_portion *portion, size_t first, size_t n_row)
{
    size_t n = 0;
    for (size_t i = first; i < first + n_row; i++)
        n += portion->registration.registered[i] != 0;
    return n;
}

/* Sources are told apart in either half: the sketch takes bits of both. */
static inline struct rmap_key key_of(int32_t source, struct rmap_step_hash hash)
{
    const uint64_t its = (uint64_t)(uint32_t)source;
    return (struct rmap_key){hash.low + (its + 1) * UINT64_C(0x9e3779b97f4a7c15),
                             UINT64_C(1) << 63 | hash.high << SOURCE_BITS | its};
}

/* The next ray's rows. */
static inline void pass_ray(const struct rmap_ray_columns *ray, struct rmap_path_place_of_ray *at)
{
    at->segment += ray->segment_count[at->ray];
    at->registration += ray->registration_count[at->ray];
    at->ray++;
}

/* All but the key. */
static inline void place_ray(struct rmap_path_of_ray *its, const struct rmap_path_place_of_ray *at,
                             size_t n_hit)
{
    its->ray = (uint32_t)at->ray;
    its->segment = (uint32_t)at->segment;
    its->registration = (uint32_t)at->registration;
    its->n_hit = (uint32_t)n_hit;
}

/* Rays whose path is written out one by one. */
static size_t next_walked(const struct rmap_path_hasher *hasher, const struct rmap_matched *rays,
                          struct rmap_path_place_of_ray *place, struct rmap_path_of_ray *list)
{
    const struct rmap_ray_columns *ray = &hasher->portion->ray;
    const size_t n_ray = hasher->portion->n_row[RMAP_TABLE_RAY];
    size_t n = 0, n_step;
    for (; place->ray < n_ray && n < RMAP_PATH_BATCH; pass_ray(ray, place)) {
        if ((rays->match && !rays->match[place->ray]) ||
            !rmap_path_key_of(hasher->keys, hasher->portion, place, hasher->scratch, &n_step))
            continue;
        const struct rmap_step_row row = {0, n_step * sizeof *hasher->scratch};
        struct rmap_step_hash hash;
        rmap_step_hash_rows(&hasher->keys->of_hash, (const uint8_t *)hasher->scratch, &row, 1,
                            &hash);
        place_ray(
            &list[n], place,
            count_hits(hasher->portion, place->registration, ray->registration_count[place->ray]));
        list[n++].key = key_of(ray->source[place->ray], hash);
    }
    return n;
}

/* Where the steps of rays stand. */
struct batch {
    struct rmap_step_row row[RMAP_PATH_BATCH];
    struct rmap_step_hash hash[RMAP_PATH_BATCH];
};

/* From *place on, as many as match and fit; returns how many. */
static size_t fill_batch(const struct rmap_path_hasher *hasher, const struct rmap_matched *rays,
                         struct rmap_path_place_of_ray *place, struct batch *batch,
                         struct rmap_path_of_ray *list)
{
    const struct rmap_ray_columns ray = hasher->portion->ray;
    const size_t n_ray = hasher->portion->n_row[RMAP_TABLE_RAY];
    const size_t width = hasher->is_narrow ? sizeof *hasher->few : sizeof *hasher->many;
    struct rmap_path_place_of_ray at = *place;
    size_t n = 0;
    for (; at.ray < n_ray && n < RMAP_PATH_BATCH; pass_ray(&ray, &at)) {
        place_ray(&list[n], &at, ray.registration_count[at.ray]);
        batch->row[n] =
            (struct rmap_step_row){at.segment * width, ray.segment_count[at.ray] * width};
        n += !rays->match || rays->match[at.ray];
    }
    *place = at;
    return n;
}

size_t rmap_path_hasher_next(const struct rmap_path_hasher *hasher, const struct rmap_matched *rays,
                             struct rmap_path_place_of_ray *place,
                             struct rmap_path_of_ray list[RMAP_PATH_BATCH])
{
    const struct rmap_ray_columns *ray = &hasher->portion->ray;
    const uint8_t *steps =
        hasher->is_narrow ? (const uint8_t *)hasher->few : (const uint8_t *)hasher->many;
    struct batch batch;
    if (!hasher->is_simple)
        return next_walked(hasher, rays, place, list);
    const size_t n = fill_batch(hasher, rays, place, &batch, list);
    if (n > 0)
        rmap_step_hash_rows(&hasher->keys->of_hash, steps, batch.row, n, batch.hash);
    for (size_t k = 0; k < n; k++) {
        struct rmap_path_of_ray *its = &list[k];
        if (its->n_hit > 0)
            mix_hits(hasher, its, ray->segment_count[its->ray], &batch.hash[k]);
        its->key = key_of(ray->source[its->ray], batch.hash[k]);
    }
    return n;
}

size_t rmap_path_hasher_list(const struct rmap_path_hasher *hasher, const struct rmap_matched *rays,
                             struct rmap_path_of_ray *list)
{
    struct rmap_path_of_ray some[RMAP_PATH_BATCH];
    struct rmap_path_place_of_ray place = {0};
    size_t n = 0;
    for (size_t more; (more = rmap_path_hasher_next(hasher, rays, &place, some)) > 0; n += more)
        memcpy(list + n, some, more * sizeof *some);
    return n;
}

/* Steps of legs [first, last); returns how many. */
static inline size_t copy_legs(const struct rmap_path_hasher *hasher, size_t first, size_t last,
                               rmap_path_step *to)
{
    for (size_t i = first; i < last; i++)
        to[i - first] = hasher->is_narrow ? hasher->few[i] : hasher->many[i];
    return last - first;
}

size_t rmap_path_hasher_steps(const struct rmap_path_hasher *hasher,
                              const struct rmap_path_place_of_ray *place, rmap_path_step *to)
{
    const struct rmap_path_keys *keys = hasher->keys;
    const struct rmap_portion *portion = hasher->portion;
    const struct rmap_registration_columns *hit = &portion->registration;
    const size_t n_leg = portion->ray.segment_count[place->ray];
    const size_t end = place->registration + portion->ray.registration_count[place->ray];
    size_t at = 0, n = 0;
    if (!hasher->is_simple) {
        (void)rmap_path_key_of(keys, portion, place, to, &n);
        return n;
    }
    for (size_t i = place->registration; i < end; i++) {
        if (!hit->registered[i])
            continue;
        const struct rmap_path_hit its = keys->hit[hit->detector[i]];
        size_t leg = (size_t)hit->segment[i] + its.follows;
        leg = leg < n_leg ? leg : n_leg;
        if (leg > at)
            n += copy_legs(hasher, place->segment + at, place->segment + leg, to + n);
        at = leg > at ? leg : at;
        to[n++] = its.step;
    }
    return n + copy_legs(hasher, place->segment + at, place->segment + n_leg, to + n);
}
