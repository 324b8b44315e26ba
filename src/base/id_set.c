/* SPDX-License-Identifier: MIT
 *
 * A set of ray ids: words of 64 of them, those that have any.
 */
#include "base/id_set.h"

#include <stdlib.h>

#include "base/alloc.h"

void rmap_id_set_fini(struct rmap_id_set *set)
{
    rmap_free(set->at);
    *set = (struct rmap_id_set){0};
}

static enum rmap_status add_word(struct rmap_id_set *set, uint64_t word, uint64_t bits,
                                 struct rmap_error *err)
{
    if (set->n > 0 && set->at[set->n - 1].word == word) {
        set->at[set->n - 1].bits |= bits;
        return RMAP_OK;
    }
    enum rmap_status st = RMAP_RESERVE(set->at, set->cap, set->n + 1, err);
    if (st != RMAP_OK)
        return st;
    set->is_unsettled |= set->n > 0 && word < set->at[set->n - 1].word;
    set->at[set->n++] = (struct rmap_id_word){word, bits};
    return RMAP_OK;
}

enum rmap_status rmap_id_set_add(struct rmap_id_set *set, uint64_t id, struct rmap_error *err)
{
    return add_word(set, id / 64, (uint64_t)1 << id % 64, err);
}

enum rmap_status rmap_id_set_add_words(struct rmap_id_set *set, const struct rmap_id_word *word,
                                       size_t n, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < n && st == RMAP_OK; i++)
        st = add_word(set, word[i].word, word[i].bits, err);
    return st;
}

static int by_word(const void *a, const void *b)
{
    const uint64_t x = ((const struct rmap_id_word *)a)->word,
                   y = ((const struct rmap_id_word *)b)->word;
    return (x > y) - (x < y);
}

void rmap_id_set_settle(struct rmap_id_set *set)
{
    size_t kept = 0;
    if (!set->is_unsettled)
        return;
    qsort(set->at, set->n, sizeof *set->at, by_word);
    for (size_t i = 0; i < set->n; i++)
        if (kept > 0 && set->at[kept - 1].word == set->at[i].word)
            set->at[kept - 1].bits |= set->at[i].bits;
        else
            set->at[kept++] = set->at[i];
    set->n = kept;
    set->is_unsettled = false;
}

uint64_t rmap_id_set_count(const struct rmap_id_set *set)
{
    uint64_t count = 0;
    for (size_t i = 0; i < set->n; i++)
        count += (uint64_t)__builtin_popcountll(set->at[i].bits);
    return count;
}

/* The first row of this word or a later one. */
static size_t lower_bound(const struct rmap_id_set *set, uint64_t word)
{
    size_t low = 0, high = set->n;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (set->at[middle].word < word)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

bool rmap_id_set_meets(const struct rmap_id_set *set, uint64_t first, uint64_t last)
{
    for (size_t i = lower_bound(set, first / 64); i < set->n && set->at[i].word <= last / 64; i++) {
        uint64_t bits = set->at[i].bits;
        if (set->at[i].word == first / 64)
            bits &= UINT64_MAX << first % 64;
        if (set->at[i].word == last / 64)
            bits &= UINT64_MAX >> (63 - last % 64);
        if (bits)
            return true;
    }
    return false;
}

void rmap_id_set_mark(const struct rmap_id_set *set, const uint64_t *id, size_t n, uint8_t *inside)
{
    size_t at = n > 0 ? lower_bound(set, id[0] / 64) : 0;
    for (size_t i = 0; i < n; i++) {
        if (i > 0 && id[i] < id[i - 1])
            at = lower_bound(set, id[i] / 64);
        while (at < set->n && set->at[at].word < id[i] / 64)
            at++;
        inside[i] =
            at < set->n && set->at[at].word == id[i] / 64 && set->at[at].bits >> id[i] % 64 & 1;
    }
}
