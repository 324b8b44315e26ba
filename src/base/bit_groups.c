/* SPDX-License-Identifier: MIT */
#include "base/bit_groups.h"

#include <string.h>

#include "base/alloc.h"
#include "base/byte_set.h"
#include "base/wide.h"

/* Bits that are written one after the other. */
struct stream {
    uint64_t *to, word;
    unsigned n; /* of the word, below 64 */
};

static inline void put(struct stream *stream, uint64_t bits, unsigned n)
{
    stream->word |= bits << stream->n;
    stream->n += n;
    if (stream->n >= 64) {
        stream->n -= 64;
        *stream->to++ = stream->word;
        stream->word = n > stream->n ? bits >> (n - stream->n - 1) >> 1 : 0;
    }
}

/* a - b - *borrow; *borrow: whether that is below 0. */
static inline uint64_t subtract(uint64_t a, uint64_t b, unsigned char *borrow)
{
    uint64_t less = a - b, rest = less - *borrow;
    *borrow = (unsigned char)((a < b) | (less < *borrow));
    return rest;
}

/* A group's bits but the last, and a bit at its end, are a number, from which a bit at its
 * beginning is taken: that clears the lowest bit and sets those below, so that `and` leaves the
 * others. The bit at the end stays if there was one. Once for each bit that a group must have; the
 * last bit of a group counts as one more than the others. */
struct borrows {
    unsigned char of[RMAP_BIT_GROUPS_LEAST_MAX];
    uint64_t before; /* 1: a group begins with the next word */
};

/* Of the groups that end in a word, a bit at the end of each that has so many. */
static inline uint64_t reach_word(uint64_t own, uint64_t end, uint32_t least,
                                  struct borrows *borrows)
{
    uint64_t begin = end << 1 | borrows->before, number = own | end;
    uint64_t rest = UINT64_MAX, fewer = rest;
    borrows->before = end >> 63;
    for (uint32_t k = 0; k < least; k++) {
        fewer = rest;
        rest = subtract(number, begin, &borrows->of[k]);
        number = (number & rest) | end;
    }
    return (rest | (fewer & own)) & end;
}

static void pack_bits(const uint64_t *bits, const uint64_t *at, size_t n_word, uint64_t *out)
{
    struct stream stream = {.to = out};
    for (size_t w = 0; w < n_word; w++)
        for (uint64_t left = at[w]; left != 0; left &= left - 1)
            put(&stream, (bits[w] & left & (0 - left)) != 0, 1);
    *stream.to = stream.word;
}

static void reach_bits(const uint64_t *bits, const uint64_t *last, size_t n_word, uint32_t least,
                       uint64_t *out)
{
    struct borrows borrows = {.before = 1};
    struct stream stream = {.to = out};
    for (size_t w = 0; w < n_word; w++) {
        uint64_t found = reach_word(bits[w], last[w], least, &borrows);
        for (uint64_t left = last[w]; left != 0; left &= left - 1)
            put(&stream, (found & left & (0 - left)) != 0, 1);
    }
    *stream.to = stream.word;
}

static void spread_bits(const uint64_t *packed, const uint64_t *filled, size_t n_word,
                        uint64_t *out)
{
    for (size_t w = 0, next = 0; w < n_word; w++) {
        out[w] = 0;
        for (uint64_t left = filled[w]; left != 0; left &= left - 1, next++)
            out[w] |= packed[next / 64] >> next % 64 & 1 ? left & (0 - left) : 0;
    }
}

/* One bit for each group that has bits becomes one for each group. */
static void give(const struct rmap_bit_groups *groups, const uint64_t *packed, uint64_t *out)
{
    size_t n_out = rmap_bit_words(groups->n_group);
    if (groups->has_empty)
        spread_bits(packed, groups->filled, n_out, out);
    else
        memcpy(out, packed, n_out * sizeof *out);
}

/* The same of bits at the places `at`, one for each group that has bits. */
static void pack(const struct rmap_bit_groups *groups, const uint64_t *bits, const uint64_t *at,
                 uint64_t *out)
{
    size_t n_word = rmap_bit_words(groups->n_bit);
    uint64_t *packed = groups->found + n_word + 1;
    pack_bits(bits, at, n_word, packed);
    give(groups, packed, out);
}

/* Bits in all of BLOCK groups, which are below 2^26 each, or any at all; *least: in one of them. */
enum { BLOCK = 64, SMALL_BITS = 26 };
RMAP_WIDE static uint64_t add_up(const uint32_t size[BLOCK], uint32_t *least)
{
    uint32_t sum = 0, any = 0, low = UINT32_MAX;
    uint64_t large = 0;
    for (size_t i = 0; i < BLOCK; i++) {
        sum += size[i];
        any |= size[i];
        low = size[i] < low ? size[i] : low;
    }
    for (size_t i = 0; any >> SMALL_BITS && i < BLOCK; i++)
        large += size[i];
    *least = low;
    return large ? large : sum;
}

/* Marks where groups end that begin behind bit `at`, which a group of no bits marks again; returns
 * the last of these bits. */
static uint64_t mark_block(const uint32_t size[BLOCK], uint64_t at, uint64_t *end)
{
    for (size_t i = 0; i < BLOCK; i++) {
        at += size[i];
        end[at / 64] |= UINT64_C(1) << at % 64;
    }
    return at;
}

/* Marks ends and groups that have bits; false: these are not n_bit bits. */
static bool mark_ends(struct rmap_bit_groups *groups)
{
    uint64_t *end = groups->last - 1; /* of a group of no bits at the beginning: bit -1 */
    uint64_t at = 63, empty = 0;
    for (size_t first = 0; first < groups->n_group; first += BLOCK) {
        uint32_t some[BLOCK] = {0}, least;
        const uint32_t *size = groups->size + first;
        const size_t n = groups->n_group - first < BLOCK ? groups->n_group - first : BLOCK;
        const uint64_t all = UINT64_MAX >> (64 - n);
        uint64_t filled = all;
        if (n < BLOCK) /* the last ones */
            size = memcpy(some, size, n * sizeof *size);
        if (add_up(size, &least) > groups->n_bit - (at - 63))
            return false;
        if (least == 0)
            rmap_keep_any_bits(size, n, UINT32_MAX, &filled);
        groups->filled[first / 64] = filled;
        empty |= filled ^ all;
        at = mark_block(size, at, end);
    }
    groups->has_empty = empty != 0;
    return at - 63 == groups->n_bit;
}

/* A word before the first of `last`, and one behind. */
size_t rmap_bit_groups_words(size_t n_group, size_t n_bit)
{
    return rmap_bit_words(n_bit) + 2 + rmap_bit_words(n_group);
}

/* made: NULL for memory of its own. */
static enum rmap_status lay_out(struct rmap_bit_groups *groups, const uint32_t *size,
                                size_t n_group, size_t n_bit, uint64_t *made,
                                struct rmap_error *err)
{
    const size_t n_word = rmap_bit_words(n_bit), n_made = rmap_bit_groups_words(n_group, n_bit);
    enum rmap_status st =
        RMAP_RESERVE(groups->memory, groups->cap, (made ? n_made : 2 * n_made) + 2, err);
    if (st != RMAP_OK)
        return st;
    groups->n_group = n_group;
    groups->n_bit = n_bit;
    groups->size = size;
    groups->found = groups->memory;
    groups->last = (made ? made : groups->memory + n_made + 2) + 1;
    groups->filled = groups->last + n_word + 1;
    return RMAP_OK;
}

enum rmap_status rmap_bit_groups_make(struct rmap_bit_groups *groups, const uint32_t *size,
                                      size_t n_group, size_t n_bit, uint64_t *made,
                                      struct rmap_error *err)
{
    enum rmap_status st = lay_out(groups, size, n_group, n_bit, made, err);
    if (st != RMAP_OK)
        return st;
    memset(groups->last - 1, 0, (rmap_bit_words(n_bit) + 2) * sizeof *groups->last);
    if (!mark_ends(groups))
        st = rmap_error_set(err, RMAP_FORMAT, "the rows of %zu rays do not add up to %zu", n_group,
                            n_bit);
    return st;
}

enum rmap_status rmap_bit_groups_set(struct rmap_bit_groups *groups, const uint32_t *size,
                                     size_t n_group, size_t n_bit, struct rmap_error *err)
{
    return rmap_bit_groups_make(groups, size, n_group, n_bit, NULL, err);
}

enum rmap_status rmap_bit_groups_reuse(struct rmap_bit_groups *groups, const uint32_t *size,
                                       size_t n_group, size_t n_bit, uint64_t *made, bool has_empty,
                                       struct rmap_error *err)
{
    groups->has_empty = has_empty;
    return lay_out(groups, size, n_group, n_bit, made, err);
}

void rmap_bit_groups_fini(struct rmap_bit_groups *groups)
{
    rmap_free(groups->memory);
    *groups = (struct rmap_bit_groups){0};
}

void rmap_bit_groups_reach(struct rmap_bit_groups *groups, const uint64_t *bits, uint32_t least,
                           uint64_t *out)
{
    size_t n_word = rmap_bit_words(groups->n_bit);
    uint64_t *packed = groups->found + n_word + 1;
    reach_bits(bits, groups->last, n_word, least, packed);
    give(groups, packed, out);
}

void rmap_bit_groups_keep_behind(const struct rmap_bit_groups *groups, const uint64_t *bits,
                                 uint64_t *next)
{
    unsigned char borrow = 0;
    const uint64_t *last = groups->last;
    uint64_t before = 1;
    size_t n_word = rmap_bit_words(groups->n_bit);
    for (size_t w = 0; w < n_word; w++) {
        uint64_t end = last[w], begin = end << 1 | before;
        uint64_t number = bits[w] | end, rest = subtract(number, begin, &borrow);
        before = end >> 63;
        next[w] &= ~(number ^ rest);
    }
}

void rmap_bit_groups_keep_first(const struct rmap_bit_groups *groups, uint64_t *bits)
{
    const uint64_t *last = groups->last;
    uint64_t before = 1;
    size_t n_word = rmap_bit_words(groups->n_bit);
    for (size_t w = 0; w < n_word; w++) {
        bits[w] &= last[w] << 1 | before;
        before = last[w] >> 63;
    }
}

void rmap_bit_groups_first(struct rmap_bit_groups *groups, const uint64_t *bits, uint64_t *out)
{
    uint64_t before = 1;
    size_t n_word = rmap_bit_words(groups->n_bit);
    for (size_t w = 0; w < n_word; w++) {
        groups->found[w] = groups->last[w] << 1 | before;
        before = groups->last[w] >> 63;
    }
    if (groups->n_bit % 64 > 0) /* behind the last group there is none */
        groups->found[n_word - 1] &= (UINT64_C(1) << groups->n_bit % 64) - 1;
    pack(groups, bits, groups->found, out);
}

void rmap_bit_groups_last(struct rmap_bit_groups *groups, const uint64_t *bits, uint64_t *out)
{
    pack(groups, bits, groups->last, out);
}
