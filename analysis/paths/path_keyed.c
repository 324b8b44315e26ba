/* SPDX-License-Identifier: MIT
 *
 * Keys of a portion's rays, column by column: most loops are without a branch.
 */
#include "analysis/paths/path_hash.h"
#include "analysis/paths/path_key_internal.h"
#include "base/alloc.h"
#include "base/wide.h"

enum { SOURCE_BITS = 20 };

/* Columns of `keyed`, one behind the other in one block. */
enum { LONG_COLUMNS = 2, SHORT_COLUMNS = 6 };

static enum rmap_status reserve(struct rmap_path_keyed *keyed, size_t n, struct rmap_error *err)
{
    enum { ROW_NBYTES = LONG_COLUMNS * sizeof(uint64_t) + SHORT_COLUMNS * sizeof(uint32_t) };
    if (n <= keyed->cap)
        return RMAP_OK;
    uint64_t *block = rmap_alloc_unset(n, ROW_NBYTES);
    if (!block)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the paths of %zu rays", n);
    rmap_free(keyed->low);
    uint32_t *column = (uint32_t *)(block + LONG_COLUMNS * n);
    *keyed = (struct rmap_path_keyed){.cap = n,
                                      .low = block,
                                      .high = block + n,
                                      .ray = column,
                                      .segment = column + n,
                                      .registration = column + 2 * n,
                                      .own_n_leg = column + 3 * n,
                                      .n_hit = column + 4 * n,
                                      .own_until = column + 5 * n};
    return RMAP_OK;
}

/* Where rows of each ray begin. */
static void add_up(const uint32_t *count, size_t n, uint32_t *first)
{
    uint32_t sum = 0;
    for (size_t i = 0; i < n; i++) {
        first[i] = sum;
        sum += count[i];
    }
}

static void place_all(const struct rmap_portion *portion, struct rmap_path_keyed *keyed)
{
    const struct rmap_ray_columns *ray = &portion->ray;
    const size_t n = portion->n_row[RMAP_TABLE_RAY];
    for (size_t i = keyed->n_same; i < n; i++)
        keyed->ray[i] = (uint32_t)i;
    keyed->n_same = n > keyed->n_same ? n : keyed->n_same;
    add_up(ray->segment_count, n, keyed->segment);
    add_up(ray->registration_count, n, keyed->registration);
    keyed->n_leg = ray->segment_count;
    memcpy(keyed->n_hit, ray->registration_count, n * sizeof *keyed->n_hit);
    keyed->n = n;
}

/* Without a branch; one ray more than match is written to. */
static void place_matching(const struct rmap_portion *portion, const uint8_t *match,
                           struct rmap_path_keyed *keyed)
{
    const struct rmap_ray_columns *ray = &portion->ray;
    const struct rmap_path_keyed to = *keyed;
    uint32_t segment = 0, registration = 0;
    size_t n = 0;
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_RAY]; i++) {
        const uint32_t n_leg = ray->segment_count[i], n_hit = ray->registration_count[i];
        to.ray[n] = (uint32_t)i;
        to.segment[n] = segment;
        to.registration[n] = registration;
        to.own_n_leg[n] = n_leg;
        to.n_hit[n] = n_hit;
        segment += n_leg;
        registration += n_hit;
        n += match[i];
    }
    keyed->n_leg = to.own_n_leg;
    keyed->n_same = 0;
    keyed->n = n;
}

/* Upper bits come down: hashes were mixed well before registrations were. */
static inline uint64_t finish(uint64_t x)
{
    x = (x ^ x >> 32) * UINT64_C(0xff51afd7ed558ccd);
    return x ^ x >> 29;
}

/* Sources are told apart in either half: the sketch takes bits of both. */
static inline uint64_t low_of(uint64_t hash, uint64_t source)
{
    return hash + (source + 1) * UINT64_C(0x9e3779b97f4a7c15);
}

static inline uint64_t high_of(uint64_t hash, uint64_t source)
{
    return UINT64_C(1) << 63 | hash << SOURCE_BITS | source;
}

/* Hashes become keys; source: [n] of all rays of the portion, or NULL: all have this one. */
RMAP_COPIED void end_some(uint64_t *restrict low, uint64_t *restrict high,
                          const uint32_t *restrict n_hit, const uint32_t *restrict ray,
                          const int32_t *restrict source, uint32_t only, size_t n)
{
    for (size_t k = 0; k < n; k++) {
        const uint64_t its = source ? (uint32_t)source[ray[k]] : only;
        low[k] = low_of(n_hit[k] > 0 ? finish(low[k]) : low[k], its);
        high[k] = high_of(n_hit[k] > 0 ? finish(high[k]) : high[k], its);
    }
}

RMAP_WIDE_PRODUCTS static void end_keys(const struct rmap_path_keyed *keyed, const int32_t *source,
                                        uint32_t only)
{
    const struct rmap_path_keyed its = *keyed;
    if (source)
        end_some(its.low, its.high, its.n_hit, its.ray, source, only, its.n);
    else
        end_some(its.low, its.high, its.n_hit, its.ray, NULL, only, its.n);
}

static uint32_t count_hits(const struct rmap_portion *portion, size_t first, size_t n_row)
{
    uint32_t n = 0;
    for (size_t i = first; i < first + n_row; i++)
        n += portion->registration.registered[i] != 0;
    return n;
}

struct rmap_key rmap_path_key_hash(const struct rmap_path_keys *keys, const rmap_path_step *symbol,
                                   size_t n, int32_t source)
{
    const uint32_t first = 0, count = (uint32_t)n;
    const struct rmap_step_rows row = {symbol, false, &first, &count, 1};
    struct rmap_key key;
    rmap_step_hash_rows(&keys->of_hash, &row, &key.low, &key.high);
    return (struct rmap_key){low_of(key.low, (uint32_t)source),
                             high_of(key.high, (uint32_t)source)};
}

/* A path that is written out; a ray may have none. */
static void key_path(const struct rmap_path_hasher *hasher, const struct rmap_path_place_of_ray *at,
                     struct rmap_path_keyed *keyed)
{
    const struct rmap_portion *portion = hasher->portion;
    const size_t n = keyed->n;
    size_t n_step;
    if (!rmap_path_key_of(hasher->keys, portion, at, hasher->scratch, &n_step))
        return;
    const struct rmap_key key =
        rmap_path_key_hash(hasher->keys, hasher->scratch, n_step, portion->ray.source[at->ray]);
    const uint32_t n_row = portion->ray.registration_count[at->ray];
    keyed->low[n] = key.low;
    keyed->high[n] = key.high;
    keyed->ray[n] = (uint32_t)at->ray;
    keyed->segment[n] = (uint32_t)at->segment;
    keyed->registration[n] = (uint32_t)at->registration;
    keyed->own_n_leg[n] = portion->ray.segment_count[at->ray];
    keyed->own_until[n] = (uint32_t)at->until;
    keyed->n_hit[n] = at->until ? 1 : count_hits(portion, at->registration, n_row);
    keyed->n++;
}

/* Rays whose paths are written out one by one. */
static void key_walked(const struct rmap_path_hasher *hasher, const struct rmap_matched *rays,
                       struct rmap_path_keyed *keyed)
{
    const struct rmap_ray_columns *ray = &hasher->portion->ray;
    const struct rmap_path_view *view = &hasher->keys->view;
    const int32_t *detector = hasher->portion->registration.detector;
    const uint8_t *counts = rmap_registrations_counted(rays);
    struct rmap_path_place_of_ray at = {0};
    keyed->n = 0;
    for (; at.ray < hasher->portion->n_row[RMAP_TABLE_RAY]; at.ray++) {
        const size_t end = at.registration + ray->registration_count[at.ray];
        const bool counted = !rays->match || rays->match[at.ray];
        at.until = 0;
        if (counted && !view->until_detector)
            key_path(hasher, &at, keyed);
        for (size_t i = at.registration; counted && view->until_detector && i < end; i++) {
            at.until = i + 1;
            if (counts[i] && detector[i] == view->detector)
                key_path(hasher, &at, keyed);
        }
        at.segment += ray->segment_count[at.ray];
        at.registration = end;
    }
    keyed->n_leg = keyed->own_n_leg;
    keyed->until = keyed->own_until;
    keyed->n_same = 0;
}

enum rmap_status rmap_path_hasher_place(struct rmap_path_hasher *hasher,
                                        const struct rmap_matched *rays, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_keyed *keyed = &hasher->keyed;
    const size_t n_more = hasher->is_simple ? 0 : hasher->portion->n_row[RMAP_TABLE_REGISTRATION];
    RMAP_TRY(reserve(keyed, rays->n_match + n_more + 1, err));
    keyed->until = NULL;
    if (!hasher->is_simple) {
        key_walked(hasher, rays, keyed);
        goto out;
    }
    if (rays->match && rays->n_match < hasher->portion->n_row[RMAP_TABLE_RAY])
        place_matching(hasher->portion, rays->match, keyed);
    else
        place_all(hasher->portion, keyed);
    st = rmap_path_hits_enter(&hasher->hits, hasher->keys, hasher->portion, err);
out:
    return st;
}

/* n of them from the first on. */
static struct rmap_path_keyed part_of(const struct rmap_path_keyed *keyed, size_t first, size_t n)
{
    return (struct rmap_path_keyed){.n = n,
                                    .low = keyed->low + first,
                                    .high = keyed->high + first,
                                    .ray = keyed->ray + first,
                                    .segment = keyed->segment + first,
                                    .registration = keyed->registration + first,
                                    .n_leg = keyed->n_leg + first,
                                    .n_hit = keyed->n_hit + first};
}

void rmap_path_hasher_key(struct rmap_path_hasher *hasher, size_t first, size_t n, int32_t source)
{
    if (!hasher->is_simple)
        return;
    const struct rmap_path_keyed keyed = part_of(&hasher->keyed, first, n);
    const struct rmap_step_rows rows = {.steps = hasher->is_narrow ? (const void *)hasher->few
                                                                   : (const void *)hasher->many,
                                        .is_narrow = hasher->is_narrow,
                                        .first = keyed.segment,
                                        .count = keyed.n_leg,
                                        .n = n};
    rmap_step_hash_rows(&hasher->keys->of_hash, &rows, keyed.low, keyed.high);
    rmap_path_hits_mix(&hasher->hits, hasher->keys, hasher->portion, &keyed);
    end_keys(&keyed, source < 0 ? hasher->portion->ray.source : NULL, (uint32_t)source);
}
