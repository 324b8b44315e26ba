/* SPDX-License-Identifier: MIT
 *
 * Registrations mixed into the hashes of rays' steps.
 */
#ifndef RMAP_PATH_HITS_H
#define RMAP_PATH_HITS_H

#include "analysis/path_key.h"

struct rmap_path_keyed;

/* One thread's; all zero at first. */
struct rmap_path_hits {
    uint64_t *word; /* [cap] of a portion's registrations */
    size_t cap;
};
void rmap_path_hits_fini(struct rmap_path_hits *hits);

/* keyed->n_hit: registrations of the rays, of which those that are registered are left; keyed->low
 * and high: hashes of their legs, into which registrations are mixed. RMAP_SYSTEM. */
enum rmap_status rmap_path_hits_mix(struct rmap_path_hits *hits, const struct rmap_path_keys *keys,
                                    const struct rmap_portion *portion,
                                    const struct rmap_path_keyed *keyed,
                                    struct rmap_error *err) RMAP_MUST_USE;

#endif
