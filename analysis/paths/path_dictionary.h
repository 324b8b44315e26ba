/* SPDX-License-Identifier: MIT
 *
 * The keys of paths that rays of a compact piece share: of its dictionary each is found once,
 * however many rays took it.
 */
#ifndef RMAP_PATH_DICTIONARY_H
#define RMAP_PATH_DICTIONARY_H

#include "analysis/paths/path_key.h"
#include "analysis/paths/path_shares.h"

/* A path of the dictionary, as a ray of it. */
struct rmap_path_known {
    struct rmap_key key; /* high 0: rays that took it have no path */
    uint32_t n_hit;      /* registrations that count */
};

/* One thread's; all zero at first. */
struct rmap_path_dictionary {
    /* [n_slot], of each piece of the map; NULL: not keyed. */
    struct rmap_path_known **slot;
    size_t n_slot, nbytes;

    /* The portion in hand. */
    const struct rmap_portion *paths; /* of its piece, as rays */
    struct rmap_path_known *known;    /* [of these] */
    size_t n;                         /* paths that its rays took */
    const uint32_t *row;              /* [n] of each, its row of the dictionary */
    struct rmap_path_shares shares;   /* of each, n_ray and first; UINT64_MAX: not looked up */
};
void rmap_path_dictionary_fini(struct rmap_path_dictionary *dictionary);

/* How paths are keyed. */
struct rmap_path_keying {
    const struct rmap_path_keys *keys;
    const struct rmap_map *map;
    int32_t detector; /* registrations on it alone count; -1: on any */
};

/* Takes a portion in hand that is summed up by its paths: rays with paths of their own are left
 * out. */
enum rmap_status rmap_path_dictionary_enter_summary(struct rmap_path_dictionary *dictionary,
                                                    const struct rmap_path_keying *keying,
                                                    const struct rmap_matched *rays,
                                                    const struct rmap_path_summary *summary,
                                                    struct rmap_error *err) RMAP_MUST_USE;

#endif
