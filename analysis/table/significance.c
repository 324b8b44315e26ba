/* SPDX-License-Identifier: MIT
 *
 * The incomplete gamma function as in Abramowitz & Stegun (1964): the series 6.5.29 below its
 * middle, the continued fraction 6.5.31 above, each where it converges fast. About sqrt(degrees)
 * terms. Binomial tails term by term.
 */
#include "analysis/table/significance.h"

#include <math.h>
#include <stdlib.h>

#include "base/alloc.h"

const char *const rmap_correction_word[RMAP_CORRECTION_COUNT + 1] = {"holm", "sidak", "none", NULL};

/* 1e6 terms reach a of 1e11, farther than any number of bins. */
enum { TERM_MAX = 1000000 };
static const double ENOUGH = 1e-16;

/* e^-x x^a / Gamma(a), without overflow. */
static double front(double a, double x)
{
    return exp(a * log(x) - x - lgamma(a));
}

/* P(a, x) */
static double series(double a, double x)
{
    double term = 1.0 / a, sum = term;
    for (int n = 1; n < TERM_MAX && term > ENOUGH * sum; n++) {
        term *= x / (a + n);
        sum += term;
    }
    return front(a, x) * sum;
}

/* Q(a, x), by the method of Lentz as Thompson & Barnett (1986, doi:10.1016/0021-9991(86)90046-X)
 * have it: x >= a + 1 keeps all denominators away from 0. */
static double fraction(double a, double x)
{
    double b = x + 1.0 - a, d = 1.0 / b, c = HUGE_VAL, value = d;
    for (int n = 1; n < TERM_MAX; n++) {
        double numerator = n * (a - n);
        b += 2.0;
        d = 1.0 / (b + numerator * d);
        c = b + (isinf(c) ? 0.0 : numerator / c);
        value *= c * d;
        if (fabs(c * d - 1.0) < ENOUGH)
            break;
    }
    return front(a, x) * value;
}

double rmap_significance_chi_square(double value, double degrees)
{
    double a = 0.5 * degrees, x = 0.5 * value;
    if (!(degrees > 0.0) || isnan(value))
        return (double)NAN;
    if (x <= 0.0)
        return 1.0;
    if (isinf(x))
        return 0.0;
    double q = x < a + 1.0 ? 1.0 - series(a, x) : fraction(a, x);
    return fmin(fmax(q, 0.0), 1.0);
}

double rmap_significance_normal(double z)
{
    return erfc(fabs(z) * sqrt(0.5));
}

/* ln P(hits of n) */
static double log_binomial(uint64_t hits, uint64_t n, double share)
{
    double k = (double)hits, m = (double)n;
    return lgamma(m + 1.0) - lgamma(k + 1.0) - lgamma(m - k + 1.0) + k * log(share) +
           (m - k) * log1p(-share);
}

double rmap_significance_binomial(uint64_t hits, uint64_t n, double share)
{
    if (share > 0.5) { /* count the rarer side */
        hits = n - hits;
        share = 1.0 - share;
    }
    double below = 0.0, at = exp(log_binomial(hits, n, share)), above = 0.0;
    double odds = share / (1.0 - share), term = at;
    for (uint64_t k = hits; k > 0; k--) {
        term *= (double)k / ((double)(n - k + 1) * odds);
        below += term;
        if (term < ENOUGH * below && (double)k < (double)n * share)
            break;
    }
    term = at;
    for (uint64_t k = hits; k < n; k++) {
        term *= (double)(n - k) * odds / (double)(k + 1);
        above += term;
        if (term < ENOUGH * above && (double)k > (double)n * share)
            break;
    }
    return fmin(1.0, 2.0 * (at + fmin(below, above)));
}

struct ranked {
    double p;
    size_t index;
};

static int by_p(const void *a, const void *b)
{
    const struct ranked *x = a, *y = b;
    if (x->p != y->p)
        return x->p < y->p ? -1 : 1;
    return x->index < y->index ? -1 : 1;
}

enum rmap_status rmap_significance_correct(enum rmap_correction correction, const double *p,
                                           size_t n, double *adjusted, struct rmap_error *err)
{
    struct ranked *list = rmap_alloc(n + 1, sizeof *list);
    size_t n_ranked = 0;
    if (!list)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu tests", n);
    for (size_t i = 0; i < n; i++) {
        adjusted[i] = p[i];
        if (!isnan(p[i]))
            list[n_ranked++] = (struct ranked){p[i], i};
    }
    qsort(list, n_ranked, sizeof *list, by_p);
    double last = 0.0;
    for (size_t k = 0; k < n_ranked && correction != RMAP_CORRECTION_NONE; k++) {
        double q = correction == RMAP_CORRECTION_HOLM
                       ? fmin(1.0, (double)(n_ranked - k) * list[k].p)
                       : -expm1((double)n_ranked * log1p(-list[k].p));
        last = fmax(last, q);
        adjusted[list[k].index] = last;
    }
    rmap_free(list);
    return RMAP_OK;
}
