/* SPDX-License-Identifier: MIT
 *
 * The promise: what a portion says about how long its rays are holds for each of them, is no wider
 * than it must be, and rows that do not fit together are refused.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <float.h>
#include <math.h>
#include <string.h>

#include "base/rng.h"
#include "compact/compact.h"
#include "compact/own_lengths.h"
#include "compact/streams.h"

enum { MOST = 3001, BEFORE = 7 };

static uint16_t row[BEFORE + MOST]; /* lanes come first */

static struct rmap_rows rows_of(size_t n)
{
    struct rmap_rows rows = {.layout = &rmap_compact_layout, .n_channel = 1};
    rows.n_row[RMAP_COMPACT_OWN] = n;
    rows.n_row[RMAP_COMPACT_POOL16] = BEFORE + rmap_own_length_rows(n);
    rows.data[RMAP_STREAM_pool16] = row;
    return rows;
}

/* widest: 1 + how far apart, relatively, two bounds may be. */
static void check(const double *length, size_t n, double widest)
{
    static struct rmap_path_sum sum[MOST];
    const struct rmap_rows rows = rows_of(n);
    assert_true(rmap_own_lengths_make(length, n, row + BEFORE));
    assert_int_equal(rmap_own_lengths_read(&rows, sum, NULL), RMAP_OK);
    for (size_t i = 0; i < n; i++) {
        const double low = (double)sum[i].path_length[0], high = (double)sum[i].path_length[1];
        assert_true(low <= length[i] && length[i] <= high);
        assert_true(high <= low * widest || high <= (double)FLT_MIN);
        assert_true(isnan(sum[i].optical_path[0]) && isnan(sum[i].optical_path[1]));
        assert_int_equal(sum[i].rays, 0);
    }
}

static void test_bounds(void **state)
{
    static double length[MOST];
    (void)state;
    for (size_t n = 1; n <= MOST; n += 750) {
        for (size_t i = 0; i < n; i++) {
            double u[4];
            rmap_rng(7, i, (uint32_t)n, 0, u);
            length[i] = 2.0 + 100.0 * u[0] * u[1];
        }
        check(length, n, 1.05);
    }
    check((double[]){17.25}, 1, 1.0000002);
    check((double[]){0.1, 0.1, 0.1}, 3, 1.0000002);
    check((double[]){1.0, nextafter(1.0, 2.0), nextafter(1.0, 0.0)}, 3, 1.0000002);
    check((double[]){0.0, DBL_MIN, 1e-40, 1.0, (double)FLT_MAX, 1e39}, 6, INFINITY);
}

static void test_none(void **state)
{
    static const double wrong[] = {NAN, INFINITY, -1.0, -0.0};
    (void)state;
    assert_false(rmap_own_lengths_make(NULL, 0, row));
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++)
        assert_false(rmap_own_lengths_make((double[]){1.0, wrong[k], 2.0}, 3, row));
}

static void test_hostile(void **state)
{
    struct rmap_path_sum sum[4];
    struct rmap_error err = {0};
    struct rmap_rows rows = rows_of(4);
    (void)state;
    memset(row, 0xff, sizeof row);
    assert_int_equal(rmap_own_lengths_read(&rows, sum, &err), RMAP_FORMAT);
    row[BEFORE + 2] = 31; /* edges beyond the infinite */
    assert_int_equal(rmap_own_lengths_read(&rows, sum, &err), RMAP_OK);
    assert_true(isinf(sum[3].path_length[0]) && isinf(sum[3].path_length[1]));
    rows.n_row[RMAP_COMPACT_POOL16] = rmap_own_length_rows(4) - 1;
    assert_int_equal(rmap_own_lengths_read(&rows, sum, &err), RMAP_FORMAT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_bounds), cmocka_unit_test(test_none),
                                       cmocka_unit_test(test_hostile)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
