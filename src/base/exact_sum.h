/* SPDX-License-Identifier: MIT
 *
 * Sums of doubles without rounding: the same bits in whatever order, on however many threads and
 * ranks the terms were added. The small superaccumulator of Neal, "Fast exact summation using
 * small and large superaccumulators" (2015), arXiv:1505.05571, section 2: a fixed-point number
 * as wide as all doubles, in words of 32 bits that overlap, so that carries may wait.
 */
#ifndef RMAP_EXACT_SUM_H
#define RMAP_EXACT_SUM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* 2^-1074 up to 2^1024, and 2^63 terms of that size. */
#define RMAP_EXACT_SUM_WORDS 68

/* Plain data: all zero is the empty sum, and its bytes may be sent. */
struct rmap_exact_sum {
    int64_t word[RMAP_EXACT_SUM_WORDS]; /* sum of word[i] 2^(32 i - 1074) */
    uint64_t n_waiting;                 /* terms since carries were last passed on */
    uint64_t n_plus_infinite, n_minus_infinite, n_nan;
};

/* A term adds less than 2^52 to a word: so many leave room for one word without carries. */
#define RMAP_EXACT_SUM_WAITING_MAX 2046

/* Passes carries on: words but the last become whole numbers of [0, 2^32). Sums of the same terms
 * are then the same bytes. */
void rmap_exact_sum_settle(struct rmap_exact_sum *sum);

/* Counts a term that is no number. */
void rmap_exact_sum_add_special(struct rmap_exact_sum *sum, double term);

static inline void rmap_exact_sum_add(struct rmap_exact_sum *sum, double term)
{
    uint64_t bits;
    memcpy(&bits, &term, sizeof bits);
    uint64_t exponent = bits >> 52 & 0x7ff;
    if (exponent == 0x7ff) {
        rmap_exact_sum_add_special(sum, term);
        return;
    }
    uint64_t normal = exponent != 0;
    uint64_t mantissa = (bits & 0xfffffffffffff) | normal << 52;
    uint64_t place = exponent - normal, shift = place & 31;
    int64_t low = (int64_t)((mantissa << shift) & 0xffffffff);
    int64_t high = (int64_t)(mantissa >> (32 - shift));
    int64_t sign = -(int64_t)(bits >> 63); /* 0 or -1: all bits turned, and 1 added, negate */
    int64_t *word = &sum->word[place >> 5];
    word[0] += (low ^ sign) - sign;
    word[1] += (high ^ sign) - sign;
    if (++sum->n_waiting == RMAP_EXACT_SUM_WAITING_MAX)
        rmap_exact_sum_settle(sum);
}

void rmap_exact_sum_merge(struct rmap_exact_sum *into, const struct rmap_exact_sum *from);

/* The sum, rounded once to the nearest double, ties to even. With terms that are no numbers: what
 * adding them gives. */
double rmap_exact_sum_value(const struct rmap_exact_sum *sum);

#endif
