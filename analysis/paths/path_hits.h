/* SPDX-License-Identifier: MIT
 *
 * Registrations mixed into the hashes of rays' steps.
 */
#ifndef RMAP_PATH_HITS_H
#define RMAP_PATH_HITS_H

#include "analysis/paths/path_key.h"

struct rmap_path_keyed;

/* One thread's; all zero at first. */
struct rmap_path_hits {
    uint64_t *word; /* [cap] of a portion's registrations */
    size_t cap;
    bool any, is_spelled; /* words are those of the portion in hand */
};
void rmap_path_hits_fini(struct rmap_path_hits *hits);

/* Takes a portion's registrations in hand. RMAP_SYSTEM. */
enum rmap_status rmap_path_hits_enter(struct rmap_path_hits *hits,
                                      const struct rmap_path_keys *keys,
                                      const struct rmap_portion *portion,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* keyed: some rays of it. keyed->n_hit: their registrations, of which those that are registered are
 * left; keyed->low and high: hashes of their legs, into which registrations are mixed. */
void rmap_path_hits_mix(const struct rmap_path_hits *hits, const struct rmap_path_keys *keys,
                        const struct rmap_portion *portion, const struct rmap_path_keyed *keyed);

#endif
