/* SPDX-License-Identifier: MIT
 *
 * The paths of a portion's rays as hashes: legs become steps table by table, those of many rays are
 * hashed in one call. Of 128 bits a key keeps 107; two rows have equal sums, of which it is made,
 * by a chance of 2^-93 (step_hash.h): of a million classes two share a key by one of 2^-54, of 100
 * million by one of 2^-40.
 */
#ifndef RMAP_PATH_HASH_H
#define RMAP_PATH_HASH_H

#include "analysis/paths/path_hits.h"
#include "analysis/paths/path_key.h"
#include "analysis/query/fold.h"
#include "analysis/table/key_slots.h"

/* Scenes with more sources are refused: a key has the source in it. */
#define RMAP_PATH_SOURCES_MAX ((size_t)1 << 20)

/* Of the path and the source of a ray: rays of a map have equal keys where both are equal. */
static inline int32_t rmap_path_source_of(struct rmap_key key)
{
    return (int32_t)(key.high & (RMAP_PATH_SOURCES_MAX - 1));
}

/* Whether a path is all of its legs and where registrations stand: rays with equal keys then have
 * as many of either. */
bool rmap_path_keys_are_simple(const struct rmap_path_keys *keys);

/* Whether steps have 16 bits. */
bool rmap_path_keys_are_narrow(const struct rmap_path_keys *keys);

/* Of a path that is written out, and its ray's source. */
struct rmap_key rmap_path_key_hash(const struct rmap_path_keys *keys, const rmap_path_step *symbol,
                                   size_t n, int32_t source);

/* Rays of a portion, of fewer than 2^32 rows, that have a path, in their order; several times those
 * that have several paths. */
struct rmap_path_keyed {
    size_t n, cap;
    uint64_t *low, *high;                   /* [n] of the key */
    uint32_t *ray, *segment, *registration; /* [n] where its rows begin */
    const uint32_t *n_leg;                  /* [n] its legs: the portion's or the next */
    uint32_t *own_n_leg, *n_hit;            /* [n] its registrations */
    const uint32_t *until;                  /* [n] of the path, as in its place; NULL: 0 */
    uint32_t *own_until;
    size_t n_same; /* of the first so many, ray[i] is i */
};

static inline struct rmap_key rmap_path_key_at(const struct rmap_path_keyed *keyed, size_t i)
{
    return (struct rmap_key){keyed->low[i], keyed->high[i]};
}

static inline struct rmap_path_place_of_ray rmap_path_place_at(const struct rmap_path_keyed *keyed,
                                                               size_t i)
{
    return (struct rmap_path_place_of_ray){keyed->ray[i], keyed->segment[i], keyed->registration[i],
                                           keyed->until ? keyed->until[i] : 0};
}

/* How many times the k-th one's ray has come to the same class before: its paths stand together. */
static inline uint32_t rmap_path_times_before(const struct rmap_path_keyed *keyed, size_t k)
{
    uint32_t n = 0;
    for (size_t i = k; keyed->until && i > 0 && keyed->ray[i - 1] == keyed->ray[k]; i--)
        n += keyed->low[i - 1] == keyed->low[k] && keyed->high[i - 1] == keyed->high[k];
    return n;
}

/* One thread's; all zero at first. */
struct rmap_path_hasher {
    const struct rmap_path_keys *keys;  /* borrowed, as is the portion */
    const struct rmap_portion *portion; /* in hand */
    bool is_simple;                     /* a path is its legs and where registrations stand */
    bool is_narrow;                     /* steps have 16 bits */
    /* [n_segment] steps, in one of these. */
    uint16_t *few;
    uint32_t *many;
    size_t few_cap, many_cap;
    rmap_path_step *scratch; /* of a ray whose path is not simply all its legs */
    size_t scratch_cap;
    struct rmap_path_hits hits;
    struct rmap_path_keyed keyed; /* by the last call of rmap_path_hasher_place */
};
void rmap_path_hasher_fini(struct rmap_path_hasher *hasher);

/* Columns of rmap_path_keys_columns that need not be there: they are fetched where they matter. */
#define RMAP_PATH_HASH_DEFERRED RMAP_COLUMN_BIT(RMAP_SEGMENT_medium)

/* Takes the rays that match in hand. */
enum rmap_status rmap_path_hasher_enter(struct rmap_path_hasher *hasher,
                                        const struct rmap_path_keys *keys,
                                        const struct rmap_matched *rays,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* Finds those that have a path: hasher->keyed, but for their keys. */
enum rmap_status rmap_path_hasher_place(struct rmap_path_hasher *hasher,
                                        const struct rmap_matched *rays,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* Keys n of them from the first on, each once. source: of all rays, or -1: the column says it. */
void rmap_path_hasher_key(struct rmap_path_hasher *hasher, size_t first, size_t n, int32_t source);

/* The steps of a ray that was keyed: at most as many as it has legs and registrations; returns how
 * many. */
size_t rmap_path_hasher_steps(const struct rmap_path_hasher *hasher,
                              const struct rmap_path_place_of_ray *place, rmap_path_step *to);

#endif
