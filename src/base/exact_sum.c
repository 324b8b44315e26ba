/* SPDX-License-Identifier: MIT
 *
 * Sums of doubles without rounding: the same bits in whatever order, on however many threads and
 * ranks the terms were added.
 */
#include "base/exact_sum.h"

#include <math.h>

#define WORD_MASK   0xffffffff
#define LAST        (RMAP_EXACT_SUM_WORDS - 1)
#define LEAST_PLACE (-1074) /* exponent of bit 0 */

void rmap_exact_sum_settle(struct rmap_exact_sum *sum)
{
    int64_t carry = 0;
    for (int i = 0; i < LAST; i++) {
        int64_t word = sum->word[i] + carry;
        int64_t rest = (int64_t)((uint64_t)word & WORD_MASK);
        carry = (word - rest) / (WORD_MASK + 1LL);
        sum->word[i] = rest;
    }
    sum->word[LAST] += carry;
    sum->n_waiting = 0;
}

void rmap_exact_sum_add_special(struct rmap_exact_sum *sum, double term)
{
    sum->n_nan += isnan(term) != 0;
    sum->n_plus_infinite += term > 0.0;
    sum->n_minus_infinite += term < 0.0;
}

void rmap_exact_sum_merge(struct rmap_exact_sum *into, const struct rmap_exact_sum *from)
{
    struct rmap_exact_sum settled = *from;
    rmap_exact_sum_settle(&settled);
    rmap_exact_sum_settle(into);
    for (int i = 0; i < RMAP_EXACT_SUM_WORDS; i++)
        into->word[i] += settled.word[i];
    into->n_waiting = 1; /* words below 2^32 are smaller than a term */
    into->n_plus_infinite += settled.n_plus_infinite;
    into->n_minus_infinite += settled.n_minus_infinite;
    into->n_nan += settled.n_nan;
}

static void negate(struct rmap_exact_sum *sum)
{
    for (int i = 0; i < RMAP_EXACT_SUM_WORDS; i++)
        sum->word[i] = -sum->word[i];
    rmap_exact_sum_settle(sum);
}

/* Bits [place, place + 64) of a settled sum that is not negative. */
static uint64_t bits_at(const struct rmap_exact_sum *sum, int place)
{
    uint64_t bits = 0;
    for (int k = 0; k < 3; k++) {
        int i = place / 32 + k, shift = 32 * k - place % 32;
        uint64_t word = i <= LAST ? (uint64_t)sum->word[i] : 0;
        if (shift < 64)
            bits |= shift < 0 ? word >> -shift : word << shift;
    }
    return bits;
}

static bool any_below(const struct rmap_exact_sum *sum, int place)
{
    for (int i = 0; i < place / 32; i++)
        if (sum->word[i])
            return true;
    return place % 32 && ((uint64_t)sum->word[place / 32] & ((1ULL << place % 32) - 1));
}

/* Of a settled sum that is not negative. */
static double rounded(const struct rmap_exact_sum *sum)
{
    int top = LAST;
    while (top >= 0 && !sum->word[top])
        top--;
    if (top < 0)
        return 0.0;
    int highest = 32 * top;
    for (uint64_t word = (uint64_t)sum->word[top]; word > 1; word >>= 1)
        highest++;
    if (highest < 53)
        return ldexp((double)bits_at(sum, 0), LEAST_PLACE); /* fits: nothing is rounded */
    int place = highest - 52;                               /* of the last bit that stays */
    uint64_t kept = bits_at(sum, place) & ((1ULL << 53) - 1);
    bool half = bits_at(sum, place - 1) & 1;
    if (half && (kept & 1 || any_below(sum, place - 1)))
        kept++;
    return ldexp((double)kept, LEAST_PLACE + place);
}

double rmap_exact_sum_value(const struct rmap_exact_sum *sum)
{
    if (sum->n_nan || (sum->n_plus_infinite && sum->n_minus_infinite))
        return NAN;
    if (sum->n_plus_infinite || sum->n_minus_infinite)
        return sum->n_plus_infinite ? INFINITY : -INFINITY;
    struct rmap_exact_sum settled = *sum;
    rmap_exact_sum_settle(&settled);
    if (settled.word[LAST] >= 0)
        return rounded(&settled);
    negate(&settled);
    return -rounded(&settled);
}
