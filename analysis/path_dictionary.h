/* SPDX-License-Identifier: MIT
 *
 * The keys of a history index's paths: of a piece's dictionary each is found once, however many
 * rays took it.
 */
#ifndef RMAP_PATH_DICTIONARY_H
#define RMAP_PATH_DICTIONARY_H

#include "analysis/path_hash.h"
#include "history/history_index.h"

/* A path of the dictionary, as a ray of it. */
struct rmap_path_known {
    struct rmap_key key; /* high 0: rays that took it have no path */
    int32_t source;
    uint32_t n_leg;
    uint32_t n_hit;                      /* registrations that count */
    struct rmap_path_place_of_ray place; /* in the dictionary */
};

/* One thread's; all zero at first. */
struct rmap_path_dictionary {
    size_t piece; /* of the map, plus 1 */
    struct rmap_path_known *path;
    size_t path_cap;
    /* Of the portion in hand: matching rays per path, and the smallest id of them. */
    uint32_t *n_ray; /* [n_path] */
    uint64_t *first; /* [n_path], UINT64_MAX: not looked up */
    size_t n_ray_cap, first_cap;
};
void rmap_path_dictionary_fini(struct rmap_path_dictionary *dictionary);

/* Takes a portion in hand that has a view in the form PATHS. detector: registrations on it alone
 * count; -1: on any. The hasher's own portion is lost. */
enum rmap_status rmap_path_dictionary_enter(struct rmap_path_dictionary *dictionary,
                                            struct rmap_path_hasher *hasher,
                                            const struct rmap_path_keys *keys, int32_t detector,
                                            size_t piece, const struct rmap_matched *rays,
                                            struct rmap_error *err) RMAP_MUST_USE;

/* Looks up `first`: the portion has ids. */
void rmap_path_dictionary_find_first(struct rmap_path_dictionary *dictionary,
                                     const struct rmap_matched *rays);

#endif
