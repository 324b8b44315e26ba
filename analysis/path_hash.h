/* SPDX-License-Identifier: MIT
 *
 * The paths of a portion's rays as hashes: legs become steps table by table, those of many rays are
 * hashed in one call. Of 128 bits a key keeps 107: with a million classes, two share a key by a
 * chance of 2^-68.
 */
#ifndef RMAP_PATH_HASH_H
#define RMAP_PATH_HASH_H

#include "analysis/fold.h"
#include "analysis/key_slots.h"
#include "analysis/path_key.h"

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

/* A ray that has a path, and where its rows begin in a portion, of fewer than 2^32 rows. */
struct rmap_path_of_ray {
    struct rmap_key key;
    uint32_t ray, segment, registration;
    uint32_t n_hit; /* its registrations */
};

static inline struct rmap_path_place_of_ray rmap_path_place_of(const struct rmap_path_of_ray *its)
{
    return (struct rmap_path_place_of_ray){its->ray, its->segment, its->registration};
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
};
void rmap_path_hasher_fini(struct rmap_path_hasher *hasher);

/* Columns of rmap_path_keys_columns that need not be there: they are fetched where they matter. */
#define RMAP_PATH_HASH_DEFERRED RMAP_COLUMN_BIT(RMAP_SEGMENT_medium)

/* Takes the rays that match in hand. */
enum rmap_status rmap_path_hasher_enter(struct rmap_path_hasher *hasher,
                                        const struct rmap_path_keys *keys,
                                        const struct rmap_matched *rays,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* Rays that are keyed together. */
enum { RMAP_PATH_BATCH = 256 };

/* The next of those that have a path, in their order: at most BATCH, from *place on, which is moved
 * behind them; all zero at first. Returns how many: 0: there are no more. */
size_t rmap_path_hasher_next(const struct rmap_path_hasher *hasher, const struct rmap_matched *rays,
                             struct rmap_path_place_of_ray *place,
                             struct rmap_path_of_ray list[RMAP_PATH_BATCH]);

/* All of them. list: room for all that match; returns how many. */
size_t rmap_path_hasher_list(const struct rmap_path_hasher *hasher, const struct rmap_matched *rays,
                             struct rmap_path_of_ray *list);

/* The steps of a ray that was listed: at most as many as it has legs and registrations; returns how
 * many. */
size_t rmap_path_hasher_steps(const struct rmap_path_hasher *hasher,
                              const struct rmap_path_place_of_ray *place, rmap_path_step *to);

#endif
