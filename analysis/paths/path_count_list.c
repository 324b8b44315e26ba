/* SPDX-License-Identifier: MIT
 *
 * Rays of a portion that are to be entered into a table of classes.
 */
#include <string.h>

#include "analysis/paths/path_count_internal.h"
#include "base/alloc.h"
#include "base/wide.h"

static enum rmap_status reserve_list(struct rmap_path_buffers *buffers, size_t n,
                                     struct rmap_error *err)
{
    n += RMAP_PATH_LIST_BEHIND;
    if (n <= buffers->left_cap)
        return RMAP_OK;
    rmap_free(buffers->left);
    rmap_free(buffers->mixed);
    buffers->left_cap = 0;
    buffers->left = rmap_alloc_unset(n, sizeof *buffers->left);
    buffers->mixed = rmap_alloc_unset(n, sizeof *buffers->mixed);
    if (!buffers->left || !buffers->mixed)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the paths of %zu rays", n);
    buffers->left_cap = n;
    return RMAP_OK;
}

/* Lists keyed rays [first, last), but for those that the cache counts, if there is one. Slots are
 * asked for ray by ray: many at once have to wait for each other. */
RMAP_COPIED void list_rays(struct rmap_path_buffers *buffers, struct rmap_class_cache *cache,
                           bool expects, size_t first, size_t last)
{
    const struct rmap_path_keyed keyed = buffers->hasher.keyed; /* copies: registers know them */
    const struct rmap_key_slots ahead = buffers->ahead;
    uint32_t *left = buffers->left;
    uint64_t *mixed = buffers->mixed;
    size_t n = buffers->n_left;
    for (size_t k = first; k < last; k++) {
        const struct rmap_key key = rmap_path_key_at(&keyed, k);
        left[n] = (uint32_t)k;
        mixed[n] = rmap_key_mixed(key);
        if (expects)
            rmap_key_slots_expect(&ahead, mixed + n, 1);
        n += !cache || !rmap_class_cache_count(cache, key, mixed[n]);
    }
    buffers->n_left = n;
}

/* Some at a time, which stay in the first cache; while the next are keyed, memory looks for the
 * slots of those before. */
enum rmap_status rmap_path_buffers_list(struct rmap_path_buffers *buffers,
                                        struct rmap_class_cache *cache, bool at_once,
                                        struct rmap_error *err)
{
    enum { TOGETHER = 256 };
    enum rmap_status st = RMAP_OK;
    const size_t n = buffers->hasher.keyed.n;
    RMAP_TRY(reserve_list(buffers, n + 1, err));
    buffers->n_left = 0;
    for (size_t first = 0; first < n; first += TOGETHER) {
        const size_t last = n - first < TOGETHER ? n : first + TOGETHER;
        rmap_path_hasher_key(&buffers->hasher, first, last - first, buffers->told.source);
        if (at_once)
            list_rays(buffers, cache, true, first, last);
        else
            list_rays(buffers, cache, false, first, last);
    }
    memset(buffers->mixed + buffers->n_left, 0, RMAP_PATH_LIST_BEHIND * sizeof *buffers->mixed);
out:
    return st;
}
