/* SPDX-License-Identifier: MIT
 *
 * Bits in groups of consecutive ones, many groups to a word: which groups have so many bits set, in
 * a few operations for all groups of a word. A group's borrow runs through its bits as through the
 * digits of a long number, and stops at its end.
 */
#ifndef RMAP_BIT_GROUPS_H
#define RMAP_BIT_GROUPS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

/* Zero it at first. */
struct rmap_bit_groups {
    size_t n_group, n_bit;
    const uint32_t *size; /* [n_group] bits of each; borrowed */
    bool has_empty;       /* a group without bits */
    uint64_t *memory;
    uint64_t *last;   /* a bit where a group ends; this and the next in `made`: */
    uint64_t *filled; /* [words of n_group] a bit for each group that has bits */
    uint64_t *found;  /* for use on the way: bits, then groups that have bits */
    size_t cap;
};

/* More set bits than this are not looked for. */
enum { RMAP_BIT_GROUPS_LEAST_MAX = 16 };

/* Words of a bit for each of n. */
static inline size_t rmap_bit_words(size_t n)
{
    return (n + 63) / 64;
}

/* Groups of size [n_group] bits, which add up to n_bit. RMAP_SYSTEM. */
enum rmap_status rmap_bit_groups_set(struct rmap_bit_groups *groups, const uint32_t *size,
                                     size_t n_group, size_t n_bit,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* The same, what tells the groups being made in the caller's memory: made
 * [rmap_bit_groups_words(n_group, n_bit)], borrowed. */
size_t rmap_bit_groups_words(size_t n_group, size_t n_bit);
enum rmap_status rmap_bit_groups_make(struct rmap_bit_groups *groups, const uint32_t *size,
                                      size_t n_group, size_t n_bit, uint64_t *made,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* Groups that were made there before, with what has_empty then was. */
enum rmap_status rmap_bit_groups_reuse(struct rmap_bit_groups *groups, const uint32_t *size,
                                       size_t n_group, size_t n_bit, uint64_t *made, bool has_empty,
                                       struct rmap_error *err) RMAP_MUST_USE;
void rmap_bit_groups_fini(struct rmap_bit_groups *groups);

/* A bit for each group: 1 for those with at least `least` of the bits set. out: [words of n_group].
 * bits: [words of n_bit]; what stands behind the last of them does not matter. least: in [1,
 * RMAP_BIT_GROUPS_LEAST_MAX]. */
void rmap_bit_groups_reach(struct rmap_bit_groups *groups, const uint64_t *bits, uint32_t least,
                           uint64_t *out);

/* The same for groups whose first bit is set, whose last one is. */
void rmap_bit_groups_first(struct rmap_bit_groups *groups, const uint64_t *bits, uint64_t *out);
void rmap_bit_groups_last(struct rmap_bit_groups *groups, const uint64_t *bits, uint64_t *out);

/* Bits stay that are the first of their group. bits: [words of n_bit]. */
void rmap_bit_groups_keep_first(const struct rmap_bit_groups *groups, uint64_t *bits);

/* Those of `next` stay that are behind one of `bits` in their group; both: [words of n_bit], not
 * the same. */
void rmap_bit_groups_keep_behind(const struct rmap_bit_groups *groups, const uint64_t *bits,
                                 uint64_t *next);

#endif
