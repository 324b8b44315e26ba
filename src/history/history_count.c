/* SPDX-License-Identifier: MIT
 *
 * Legs whose class is rare, and registrations that are wanted, as a bit each; groups that are the
 * rays'.
 */
#include <string.h>

#include "base/byte_set.h"
#include "history/history_parts.h"

const uint64_t *rmap_history_rare_legs(const struct rmap_history_view *view)
{
    struct rmap_history_rows *rows = view->rows;
    const size_t n_leg = view->n_row[RMAP_TABLE_SEGMENT];
    uint64_t *rare = rows->rare_mark;
    uint8_t member[256] = {0};
    uint32_t n = 0;
    if (rows->shape.n_rare == 0)
        return NULL;
    if (rows->made->is_ranked)
        return rare;
    for (uint32_t k = 0; k < rmap_history_n_page(rows->shape.n_local); k++)
        member[255 - k] = 1;
    if (!rows->made->has_rare)
        rmap_byte_set_bits(rows->code, n_leg, member, rare);
    for (size_t w = 0; w < rmap_bit_words(n_leg); w++) {
        rows->rank[w] = n;
        n += (uint32_t)__builtin_popcountll(rare[w]);
    }
    rows->made->has_rare = rows->made->is_ranked = 1;
    return rare;
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

/* A table's groups, of what was made of them before. has_empty: in what is made. */
static enum rmap_status set_groups(const struct rmap_history_view *view, enum rmap_table table,
                                   const uint32_t *size, uint64_t *made, uint8_t *is_made,
                                   uint8_t *has_empty, struct rmap_bit_groups *groups,
                                   struct rmap_error *err)
{
    const size_t n_ray = view->n_row[RMAP_TABLE_RAY], n_row = view->n_row[table];
    if (*is_made)
        return rmap_bit_groups_reuse(groups, size, n_ray, n_row, made, *has_empty != 0, err);
    enum rmap_status st = rmap_bit_groups_make(groups, size, n_ray, n_row, made, err);
    *is_made = st == RMAP_OK;
    *has_empty = groups->has_empty;
    return st;
}

enum rmap_status rmap_history_leg_groups(const struct rmap_history_view *view,
                                         struct rmap_bit_groups **groups_ret,
                                         struct rmap_error *err)
{
    struct rmap_history_rows *rows = view->rows;
    struct rmap_history_made *made = rows->made;
    *groups_ret = &rows->legs;
    if (rows->has_legs)
        return RMAP_OK;
    enum rmap_status st = set_groups(view, RMAP_TABLE_SEGMENT, view->segment_count, rows->made_legs,
                                     &made->has_legs, &made->legs_have_empty, &rows->legs, err);
    rows->has_legs = st == RMAP_OK;
    return st;
}

enum rmap_status rmap_history_hit_groups(const struct rmap_history_view *view,
                                         struct rmap_bit_groups **groups_ret,
                                         struct rmap_error *err)
{
    struct rmap_history_rows *rows = view->rows;
    struct rmap_history_made *made = rows->made;
    *groups_ret = &rows->hits;
    if (rows->has_hits)
        return RMAP_OK;
    enum rmap_status st =
        set_groups(view, RMAP_TABLE_REGISTRATION, view->registration_count, rows->made_hits,
                   &made->has_hits, &made->hits_have_empty, &rows->hits, err);
    rows->has_hits = st == RMAP_OK;
    return st;
}
