/* SPDX-License-Identifier: MIT
 *
 * The promise: bins of a number hold about as many readings each, wherever these are, are at most
 * as many as asked for, and none crosses the border of one that a picture shows. A comparison of
 * bins that cannot have its memory says so.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "analysis/compare/compare_cut.h"
#include "analysis/compare/difference.h"
#include "base/alloc.h"

enum { MOST = 250 };
static const size_t PER_SHOWN = RMAP_COMPARE_CELLS / RMAP_COMPARE_SHOWN;

static void check(const double *count)
{
    struct rmap_compare_cut *cut = rmap_alloc(1, sizeof *cut);
    assert_non_null(cut);
    rmap_compare_cut_make(cut, count, MOST);
    assert_in_range(cut->n_bin, RMAP_COMPARE_SHOWN, MOST);
    assert_int_equal(cut->bin[RMAP_COMPARE_CELLS - 1] + 1, cut->n_bin);
    assert_int_equal(cut->shown[RMAP_COMPARE_SHOWN], cut->n_bin);
    double all = 0.0, held = 0.0;
    for (size_t c = 0; c < RMAP_COMPARE_CELLS; c++)
        all += count[c];
    for (size_t c = 0; c < RMAP_COMPARE_CELLS; c++) {
        if (c % PER_SHOWN == 0)
            assert_int_equal(cut->shown[c / PER_SHOWN], cut->bin[c]);
        const int step = c > 0 ? cut->bin[c] - cut->bin[c - 1] : 0;
        assert_in_range(step, c > 0 && c % PER_SHOWN == 0, 1);
        held = step ? count[c] : held + count[c];
        /* A bin is full with its last cell, not before. */
        assert_true(held - count[c] < all / (MOST - RMAP_COMPARE_SHOWN) || held == count[c]);
    }
    rmap_free(cut);
}

static void test_cut(void **state)
{
    (void)state;
    double *count = rmap_alloc(RMAP_COMPARE_CELLS, sizeof *count);
    assert_non_null(count);
    check(count); /* nothing at all */
    for (size_t c = 0; c < RMAP_COMPARE_CELLS; c++)
        count[c] = 1.0;
    check(count);
    for (size_t c = 0; c < 60; c++) /* a spot */
        count[70000 + c] = 1e6;
    check(count);
    count[70030] = 1e12; /* and one value */
    check(count);
    rmap_free(count);
    assert_int_equal(rmap_alloc_live(), 0);
}

static void test_memory(void **state)
{
    (void)state;
    struct rmap_stratum stratum = {.emitted = {100.0, 100.0}, .unit = {0.01, 0.01}};
    const struct rmap_strata strata = {&stratum, 1, false};
    const double count[2][2] = {{30.0, 40.0}, {35.0, 35.0}}, *one[2] = {count[0], count[1]};
    const struct rmap_bins bins = {{&one[0], &one[1]}, 2, 0.0};
    struct rmap_chi_square result;
    struct rmap_error err = {0};
    enum rmap_status st = RMAP_SYSTEM;
    int64_t at = 1;
    for (; st != RMAP_OK && at < 20; at++) {
        rmap_alloc_fail_at(at);
        st = rmap_difference_bins(&strata, &bins, &result, &err);
        assert_true(st == RMAP_OK || st == RMAP_SYSTEM);
        assert_int_equal(rmap_alloc_live(), 0);
    }
    rmap_alloc_fail_at(0);
    assert_in_range(at, 4, 19);
    assert_true(result.p > 0.0 && result.p < 1.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_cut), cmocka_unit_test(test_memory)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
