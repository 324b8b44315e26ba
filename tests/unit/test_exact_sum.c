/* SPDX-License-Identifier: MIT
 *
 * Exact sums: against sums of fractions in Python (fractions.Fraction, rounded once by its integer
 * division) of the same made-up terms, in any order and any grouping; cancellation, ties, tiny and
 * infinite terms.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/exact_sum.h"

/* Terms of every sign with biased exponents [lowest, lowest + span), from xorshift64. */
static void make_terms(uint64_t seed, size_t n, uint64_t lowest, uint64_t span, double *term)
{
    uint64_t x = seed * 0x9e3779b97f4a7c15;
    for (size_t i = 0; i < n; i++) {
        x ^= x << 13;
        x ^= x >> 7;
        x ^= x << 17;
        uint64_t exponent = lowest + (x >> 53) % span;
        uint64_t bits = x << 63 | exponent << 52 | (x >> 1 & 0xfffffffffffff);
        memcpy(&term[i], &bits, sizeof bits);
    }
}

static double sum_of(const double *term, size_t n)
{
    struct rmap_exact_sum sum = {0};
    for (size_t i = 0; i < n; i++)
        rmap_exact_sum_add(&sum, term[i]);
    return rmap_exact_sum_value(&sum);
}

static void assert_same(double a, double b)
{
    if (memcmp(&a, &b, sizeof a) != 0)
        fail_msg("%a instead of %a", a, b);
}

/* The sum of dealt terms, merged in an order that is not that of the parts. */
static void assert_any_grouping(const double *term, size_t n, double expected)
{
    enum { N_PART = 5 };
    static const int order[N_PART] = {3, 0, 4, 1, 2};
    struct rmap_exact_sum part[N_PART] = {0}, whole = {0}, sent;
    for (size_t i = 0; i < n; i++)
        rmap_exact_sum_add(&part[i * i % N_PART], term[i]);
    for (int k = 0; k < N_PART; k++) {
        memcpy(&sent, &part[order[k]], sizeof sent);
        rmap_exact_sum_merge(&whole, &sent);
    }
    assert_same(rmap_exact_sum_value(&whole), expected);
}

static void as_fractions_do(void **state)
{
    (void)state;
    static const struct {
        uint64_t seed, n, lowest, span;
        double sum;
    } row[] = {
        {1, 5000, 0, 2047, 0x1.1cceb76a75fafp+1021},
        {2, 5000, 1000, 48, -0x1.8184eeae4e51cp+26},
        {3, 5000, 0, 60, -0x1.1fd7a6b87586bp-961},
        {4, 5000, 0, 2, 0x1.4a9d4867f6dc5p-1017},
        {5, 5000, 2040, 7, -INFINITY},
        {6, 100000, 1022, 2, -0x1.1176012483ecfp+8},
        {7, 20000, 1000, 120, -0x1.fc85688b90bd9p+99},
    };
    for (size_t r = 0; r < sizeof row / sizeof row[0]; r++) {
        double *term = calloc(row[r].n, sizeof *term);
        assert_non_null(term);
        make_terms(row[r].seed, row[r].n, row[r].lowest, row[r].span, term);
        assert_same(sum_of(term, row[r].n), row[r].sum);
        for (size_t i = row[r].n - 1; i > 0; i--) {
            size_t k = (size_t)rand() % (i + 1);
            double swapped = term[i];
            term[i] = term[k];
            term[k] = swapped;
        }
        assert_same(sum_of(term, row[r].n), row[r].sum);
        assert_any_grouping(term, row[r].n, row[r].sum);
        free(term);
    }
}

static void settled_sums_are_the_same_bytes(void **state)
{
    (void)state;
    enum { N = 3000 };
    double term[N];
    make_terms(11, N, 900, 200, term);
    struct rmap_exact_sum ascending = {0}, descending = {0};
    for (int i = 0; i < N; i++) {
        rmap_exact_sum_add(&ascending, term[i]);
        rmap_exact_sum_add(&descending, term[N - 1 - i]);
    }
    rmap_exact_sum_settle(&ascending);
    rmap_exact_sum_settle(&descending);
    assert_memory_equal(&ascending, &descending, sizeof ascending);
}

static void hard_cases(void **state)
{
    (void)state;
    assert_same(sum_of(NULL, 0), 0.0);
    assert_same(sum_of((double[]){-0.0}, 1), 0.0);
    assert_same(sum_of((double[]){1e308, 1.0, -1e308}, 3), 1.0);
    assert_same(sum_of((double[]){1e308, 1e308, -1e308}, 3), 1e308);
    assert_same(sum_of((double[]){0x1p53, 1.0}, 2), 0x1p53);                /* tie to even, down */
    assert_same(sum_of((double[]){0x1p53, 3.0}, 2), 0x1p53 + 4.0);          /* tie to even, up */
    assert_same(sum_of((double[]){0x1p53, 1.0, 0x1p-1074}, 3), 0x1p53 + 2); /* just over a tie */
    assert_same(sum_of((double[]){-0x1p53, -1.0, -0x1p-1074}, 3), -0x1p53 - 2);
    assert_same(sum_of((double[]){0x1.fffffffffffffp52, 0.5}, 2), 0x1p53);
    assert_same(sum_of((double[]){0x1p-1074, 0x1p-1074}, 2), 0x1p-1073);
    assert_same(sum_of((double[]){0x1p-1022, -0x1p-1074}, 2), 0x0.fffffffffffffp-1022);
    assert_same(sum_of((double[]){0x1.fffffffffffffp1023, 0x1p970}, 2), INFINITY);
    assert_same(sum_of((double[]){0x1.fffffffffffffp1023, 0x1.fffffffffffffp969}, 2),
                0x1.fffffffffffffp1023);
}

static void terms_that_are_no_numbers(void **state)
{
    (void)state;
    assert_same(sum_of((double[]){1.0, INFINITY, -1e308}, 3), INFINITY);
    assert_same(sum_of((double[]){-INFINITY, 1e308}, 2), -INFINITY);
    assert_true(isnan(sum_of((double[]){INFINITY, -INFINITY}, 2)));
    assert_true(isnan(sum_of((double[]){1.0, NAN}, 2)));
    struct rmap_exact_sum a = {0}, b = {0};
    rmap_exact_sum_add(&a, 1.0);
    rmap_exact_sum_add(&b, NAN);
    rmap_exact_sum_merge(&a, &b);
    assert_true(isnan(rmap_exact_sum_value(&a)));
}

/* The largest terms, all on the same words: carries are passed on before a word overflows. */
static void carries_wait_no_longer_than_they_may(void **state)
{
    (void)state;
    struct rmap_exact_sum sum = {0};
    const double term = -0x1.fffffffffffffp-20;
    for (int i = 0; i < 1 << 20; i++)
        rmap_exact_sum_add(&sum, term);
    assert_same(rmap_exact_sum_value(&sum), term * 0x1p20);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(as_fractions_do),
        cmocka_unit_test(settled_sums_are_the_same_bytes),
        cmocka_unit_test(hard_cases),
        cmocka_unit_test(terms_that_are_no_numbers),
        cmocka_unit_test(carries_wait_no_longer_than_they_may),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
