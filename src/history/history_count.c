/* SPDX-License-Identifier: MIT
 *
 * Legs whose class is wanted, and registrations: codes become a bit each, in groups that are the
 * rays'.
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

/* Lists the legs of each rare class. What is stored in the order of the legs may be shorter than it
 * should, name classes that are not there, or differ from their rows: damage that a checksum hides.
 */
static void list_rare(const struct rmap_history_view *view, const uint64_t *rare)
{
    struct rmap_history_rows *rows = view->rows;
    const struct rmap_history_shape *shape = &rows->shape;
    uint32_t used = 0, first = 0;
    for (uint32_t k = shape->n_common; k < shape->n_local; k++) {
        uint32_t room = shape->n_rare - first;
        rows->rare_first[k] = rows->rare_end[k] = first;
        first += view->local_rows[k] < room ? view->local_rows[k] : room;
    }
    for (size_t w = 0; w * 64 < view->n_row[RMAP_TABLE_SEGMENT]; w++)
        for (uint64_t left = rare[w]; left != 0 && used < shape->n_rare; left &= left - 1) {
            size_t leg = w * 64 + (size_t)__builtin_ctzll(left);
            uint32_t k = rmap_history_rare_class(shape, rows->code[leg], rows->rare[used++]);
            uint32_t end = k + 1 < shape->n_local ? rows->rare_first[k + 1] : first;
            if (k < shape->n_local && rows->rare_end[k] < end)
                rows->rare_leg[rows->rare_end[k]++] = (uint32_t)leg;
        }
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
    list_rare(view, rare);
    rows->is_ranked = true;
    return rare;
}

static void mark_rare(const struct rmap_history_view *view, const uint8_t *wanted, uint64_t *mark)
{
    const struct rmap_history_rows *rows = view->rows;
    if (!rmap_history_rare_legs(view))
        return;
    for (uint32_t k = rows->shape.n_common; k < rows->shape.n_local; k++)
        for (uint32_t i = rows->rare_first[k];
             wanted[view->local_class[k]] && i < rows->rare_end[k]; i++)
            mark[rows->rare_leg[i] / 64] |= UINT64_C(1) << rows->rare_leg[i] % 64;
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

const uint64_t *rmap_history_mark(const struct rmap_history_view *view, const uint8_t *wanted)
{
    struct wanted local;
    localise(view, wanted, &local);
    if (local.rows == 0)
        return NULL;
    mark_wanted(view, wanted, &local);
    return view->rows->mark;
}

const uint64_t *rmap_history_mark_hits(const struct rmap_history_view *view, const uint8_t *wanted)
{
    const struct rmap_history_rows *rows = view->rows;
    size_t n = view->n_row[RMAP_TABLE_REGISTRATION];
    unsigned nbytes = rows->shape.hit_nbytes;
    uint8_t member[256] = {0};
    if (n == 0 || (nbytes == 0 && !wanted[rmap_history_number(rows->hit, 0, 0)]))
        return NULL;
    memset(rows->mark_hit, nbytes == 0 ? UINT8_MAX : 0,
           rmap_history_hit_words(view) * sizeof *rows->mark_hit);
    for (size_t k = 0; k < sizeof member && k < view->index->n_hit; k++)
        member[k] = wanted[k] != 0;
    if (nbytes == 1)
        rmap_byte_set_bits(rows->hit, n, member, rows->mark_hit);
    for (size_t i = 0; nbytes == 2 && i < n; i++)
        rows->mark_hit[i / 64] |= (uint64_t)(wanted[rmap_history_number(rows->hit, nbytes, i)] != 0)
                                  << i % 64;
    return rows->mark_hit;
}

static enum rmap_status set_groups(const struct rmap_history_view *view, const uint32_t *size,
                                   enum rmap_table table, struct rmap_bit_groups *groups, bool *has,
                                   struct rmap_error *err)
{
    if (*has)
        return RMAP_OK;
    enum rmap_status st =
        rmap_bit_groups_set(groups, size, view->n_row[RMAP_TABLE_RAY], view->n_row[table], err);
    *has = st == RMAP_OK;
    return st;
}

enum rmap_status rmap_history_leg_groups(const struct rmap_history_view *view,
                                         struct rmap_bit_groups **groups_ret,
                                         struct rmap_error *err)
{
    struct rmap_history_rows *rows = view->rows;
    *groups_ret = &rows->legs;
    return set_groups(view, view->segment_count, RMAP_TABLE_SEGMENT, &rows->legs, &rows->has_legs,
                      err);
}

enum rmap_status rmap_history_hit_groups(const struct rmap_history_view *view,
                                         struct rmap_bit_groups **groups_ret,
                                         struct rmap_error *err)
{
    struct rmap_history_rows *rows = view->rows;
    *groups_ret = &rows->hits;
    return set_groups(view, view->registration_count, RMAP_TABLE_REGISTRATION, &rows->hits,
                      &rows->has_hits, err);
}
