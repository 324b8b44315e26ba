/* SPDX-License-Identifier: MIT */
#include "analysis/paths/path_hash.h"

#include "analysis/paths/path_key_internal.h"
#include "base/alloc.h"

void rmap_path_hasher_fini(struct rmap_path_hasher *hasher)
{
    rmap_free(hasher->few);
    rmap_free(hasher->many);
    rmap_free(hasher->scratch);
    rmap_path_hits_fini(&hasher->hits);
    rmap_free(hasher->keyed.low);
    *hasher = (struct rmap_path_hasher){0};
}

bool rmap_path_keys_are_simple(const struct rmap_path_keys *keys)
{
    return !keys->view.collapsed && !keys->view.until_detector;
}

bool rmap_path_keys_are_narrow(const struct rmap_path_keys *keys)
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
    enum rmap_status st =
        RMAP_RESERVE(hasher->scratch, hasher->scratch_cap, longest + RMAP_STEP_HASH_BEHIND, err);
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
    hasher->is_narrow = rmap_path_keys_are_narrow(keys);
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
