/* SPDX-License-Identifier: MIT
 *
 * Counts the legs of each ray whose class is wanted: codes become a bit per leg, and each ray
 * counts its own.
 */
#include <string.h>

#include "base/byte_set.h"
#include "base/wide.h"
#include "history/history_parts.h"

/* What is wanted, by local class. */
struct wanted {
    uint8_t common[256]; /* by code; 0 for those of rare classes */
    bool rare;           /* any of those without a code */
    uint64_t rows;       /* legs in all */
};

static void localise(const struct rmap_history_view *view, const uint8_t *wanted,
                     struct wanted *out)
{
    const uint32_t n_common = view->rows->shape.n_common;
    *out = (struct wanted){.rows = 0};
    for (size_t k = 0; k < view->n_local; k++) {
        bool is = wanted[view->local_class[k]] != 0;
        out->rows += is ? view->local_rows[k] : 0;
        if (k < n_common)
            out->common[k] = is;
        else
            out->rare |= is;
    }
}

void rmap_history_mark_codes(const struct rmap_history_view *view, const uint8_t member[256],
                             uint64_t *mark)
{
    rmap_byte_set_bits(view->rows->code, view->n_row[RMAP_TABLE_SEGMENT], member, mark);
}

const uint64_t *rmap_history_rare_legs(const struct rmap_history_view *view)
{
    struct rmap_history_rows *rows = view->rows;
    size_t n_word = rmap_history_mark_words(view);
    uint64_t *rare = rows->mark + n_word;
    uint8_t member[256] = {0};
    uint32_t n = 0;
    if (rows->shape.n_rare == 0)
        return NULL;
    if (rows->is_ranked)
        return rare;
    for (uint32_t k = 0; k < rmap_history_n_page(rows->shape.n_local); k++)
        member[255 - k] = 1;
    rmap_history_mark_codes(view, member, rare);
    n_word = (view->n_row[RMAP_TABLE_SEGMENT] + 63) / 64;
    for (size_t w = 0; w < n_word; w++) {
        rows->rank[w] = n;
        n += (uint32_t)__builtin_popcountll(rare[w]);
    }
    rows->is_ranked = true;
    return rare;
}

/* Rare classes stand in their list in the order of the legs. Lists may be shorter than they should:
 * damage that a checksum hides. */
static void mark_rare(const struct rmap_history_view *view, const uint8_t *wanted, uint64_t *mark)
{
    const struct rmap_history_rows *rows = view->rows;
    const struct rmap_history_shape *shape = &rows->shape;
    const uint64_t *rare = rmap_history_rare_legs(view);
    uint32_t used = 0;
    for (size_t w = 0; rare && w * 64 < view->n_row[RMAP_TABLE_SEGMENT]; w++)
        for (uint64_t left = rare[w]; left != 0 && used < shape->n_rare; left &= left - 1) {
            uint8_t code = rows->code[w * 64 + (size_t)__builtin_ctzll(left)];
            uint32_t k = rmap_history_rare_class(shape, code, rows->rare[used++]);
            bool is = k < shape->n_local && wanted[view->local_class[k]] != 0;
            mark[w] |= is ? left & (0 - left) : 0;
        }
}

/* What is wanted as bits in the view's marks. */
static void mark_wanted(const struct rmap_history_view *view, const uint8_t *wanted,
                        const struct wanted *local)
{
    uint64_t *mark = view->rows->mark;
    rmap_history_mark_codes(view, local->common, mark);
    if (local->rare)
        mark_rare(view, wanted, mark);
}

void rmap_history_count(const struct rmap_history_view *view, const uint8_t *wanted,
                        uint32_t *count)
{
    size_t n_ray = view->n_row[RMAP_TABLE_RAY];
    struct wanted local;
    localise(view, wanted, &local);
    if (local.rows == 0) {
        memset(count, 0, n_ray * sizeof *count);
    } else if (local.rows == view->n_row[RMAP_TABLE_SEGMENT]) {
        memcpy(count, view->segment_count, n_ray * sizeof *count);
    } else {
        mark_wanted(view, wanted, &local);
        rmap_bits_count_groups(view->rows->mark, view->segment_count, n_ray, count);
    }
}

/* Of n rays those with a marked leg. */
RMAP_WIDE static size_t keep_marked(const uint64_t *mark, const uint32_t *segment_count,
                                    struct rmap_history_place_of_ray *ray, size_t n)
{
    size_t n_kept = 0;
    for (size_t i = 0; i < n; i++) {
        const struct rmap_history_place_of_ray it = ray[i];
        ray[n_kept] = it;
        n_kept += rmap_bits_count(mark, it.leg, segment_count[it.ray]) > 0;
    }
    return n_kept;
}

size_t rmap_history_keep(const struct rmap_history_view *view, const uint8_t *wanted,
                         struct rmap_history_place_of_ray *ray, size_t n)
{
    struct wanted local;
    localise(view, wanted, &local);
    if (local.rows == 0 || n == 0)
        return 0;
    mark_wanted(view, wanted, &local);
    return keep_marked(view->rows->mark, view->segment_count, ray, n);
}

void rmap_history_count_hits(const struct rmap_history_view *view, const uint8_t *wanted,
                             uint32_t *count)
{
    const struct rmap_history_rows *rows = view->rows;
    size_t n_ray = view->n_row[RMAP_TABLE_RAY], at = 0;
    unsigned nbytes = rows->shape.hit_nbytes;
    if (!view->registration_count) {
        memset(count, 0, n_ray * sizeof *count);
        return;
    }
    if (nbytes == 0) {
        uint32_t all = wanted[rmap_history_number(rows->hit, 0, 0)] ? UINT32_MAX : 0;
        for (size_t i = 0; i < n_ray; i++)
            count[i] = view->registration_count[i] & all;
        return;
    }
    for (size_t i = 0; i < n_ray; i++) {
        count[i] = 0;
        for (size_t end = at + view->registration_count[i]; at < end; at++)
            count[i] += wanted[rmap_history_number(rows->hit, nbytes, at)] != 0;
    }
}
