/* SPDX-License-Identifier: MIT
 *
 * Sums of powers: as an exact sum of one of them; the same bits in any order and grouping of
 * portions. Moments of a two-point distribution and their errors in closed form. Bins against their
 * own edges.
 */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "analysis/stats/stats.h"
#include "base/alloc.h"
#include "base/rng.h"

enum { N = 15000, PORTION = 2500 };

static void make_values(double *u)
{
    for (uint64_t k = 0; k < N; k++) {
        double r[4];
        rmap_rng(11, k, 0, RMAP_RNG_EMIT_POINT, r);
        u[k] = (2.0 * r[0] - 1.0) * (r[1] < 0.5 ? 1.0 : 1e-5);
    }
}

/* A portion with rays of one reading of weight 1, and others. */
static void add_portion(struct rmap_stats_moments *moments, const double *u)
{
    for (size_t k = 0; k < PORTION; k++) {
        const double square = u[k] * u[k];
        const double one[RMAP_MOMENTS] = {1.0, u[k], square, square * u[k], square * square};
        const double q[RMAP_MOMENTS] = {2.0, u[k], square, 0.0, 0.0};
        rmap_stats_moments_add(moments, one);
        rmap_stats_moments_add(moments, q);
    }
    rmap_stats_moments_flush(moments);
}

static void powers_are_summed_in_any_order(void **state)
{
    (void)state;
    double u[N], total[2][RMAP_MOMENTS], product[2][RMAP_MOMENTS][RMAP_MOMENTS];
    struct rmap_stats_moments *m = rmap_alloc(3, sizeof *m);
    assert_non_null(m);
    make_values(u);
    for (size_t p = 0; p < N / PORTION; p++) {
        add_portion(&m[0], u + p * PORTION);
        add_portion(&m[p % 3 == 0 ? 1 : 2], u + (N / PORTION - 1 - p) * PORTION);
    }
    rmap_stats_moments_merge(&m[2], &m[1]);
    rmap_stats_moments_value(&m[0], total[0], product[0]);
    rmap_stats_moments_value(&m[2], total[1], product[1]);
    assert_memory_equal(total[0], total[1], sizeof total[0]);
    assert_memory_equal(product[0], product[1], sizeof product[0]);
    struct rmap_exact_sum eighth = {0};
    for (size_t k = 0; k < N; k++)
        rmap_exact_sum_add(&eighth, pow(u[k], 8.0));
    const double sum = rmap_exact_sum_value(&eighth);
    assert_true(fabs(product[0][4][4] - sum) <= 1e-14 * sum);
    assert_true(total[0][0] == 3.0 * N);
    rmap_free(m);
}

static void assert_near(double a, double b)
{
    if (!(fabs(a - b) <= 1e-12 * fmax(fabs(a), fabs(b))))
        fail_msg("%.17g instead of %.17g", a, b);
}

/* Values 7 and 11, the latter with probability p, n rays all of which have one. Errors by the delta
 * method on a binomial p: |d statistic / dp| sqrt(p (1 - p) / (n - 1)). */
static void two_points_have_the_moments_of_two_points(void **state)
{
    (void)state;
    const double n = 400, p = 0.2, f = 0.01, q = p * (1 - p), centre = 9, scale = 2;
    double total[RMAP_MOMENTS], covariance[RMAP_MOMENTS][RMAP_MOMENTS];
    double sum[RMAP_MOMENTS], product[RMAP_MOMENTS][RMAP_MOMENTS];
    for (int j = 0; j < RMAP_MOMENTS; j++) {
        sum[j] = n * (j % 2 ? 2 * p - 1 : 1); /* u is 1 or -1 */
        total[j] = f * sum[j];
    }
    for (int j = 0; j < RMAP_MOMENTS; j++)
        for (int k = 0; k < RMAP_MOMENTS; k++) {
            product[j][k] = n * ((j + k) % 2 ? 2 * p - 1 : 1);
            covariance[j][k] = f * f * n / (n - 1) * (product[j][k] - sum[j] * sum[k] / n);
        }
    struct rmap_stats_moment_estimates got;
    rmap_stats_estimate_moments(total, covariance, centre, scale, &got);
    const double e = sqrt(q / (n - 1));
    assert_near(got.flux.value, 4.0);
    assert_true(got.flux.standard_error < 1e-12);
    assert_near(got.mean.value, 7.8);
    assert_near(got.mean.standard_error, 4 * e);
    assert_near(got.deviation.value, 4 * sqrt(q));
    assert_near(got.deviation.standard_error, 4 * (1 - 2 * p) / (2 * sqrt(q)) * e);
    assert_near(got.skewness.value, (1 - 2 * p) / sqrt(q));
    assert_near(got.skewness.standard_error,
                fabs(-2 / sqrt(q) - (1 - 2 * p) * (1 - 2 * p) / (2 * q * sqrt(q))) * e);
    assert_near(got.kurtosis.value, 1 / q - 3);
    assert_near(got.kurtosis.standard_error, (1 - 2 * p) / (q * q) * e);
    total[0] = 0.0;
    rmap_stats_estimate_moments(total, covariance, centre, scale, &got);
    assert_true(isnan(got.mean.value) && isnan(got.kurtosis.standard_error));
}

/* Every edge and its neighbours fall where the edges say. */
static void assert_bins(const struct rmap_bins *bins)
{
    for (size_t k = 0; k <= bins->n; k++) {
        double edge = bins->edge[k];
        assert_true(rmap_bin_of(bins, edge) == (k < bins->n ? k : k - 1));
        assert_true(rmap_bin_of(bins, nextafter(edge, -DBL_MAX)) ==
                    (k > 0 ? k - 1 : RMAP_BIN_BELOW));
        if (k == bins->n)
            assert_true(rmap_bin_of(bins, nextafter(edge, DBL_MAX)) == RMAP_BIN_ABOVE);
        else
            assert_true(rmap_bin_of(bins, 0.5 * edge + 0.5 * bins->edge[k + 1]) == k);
    }
}

static void bins_hold_what_their_edges_say(void **state)
{
    (void)state;
    struct rmap_bins bins;
    struct rmap_error err;
    assert_int_equal(rmap_bins_equal(-0.1, 0.2, 77, false, &bins, &err), RMAP_OK);
    assert_bins(&bins);
    rmap_bins_fini(&bins);
    assert_int_equal(rmap_bins_equal(1e-3, 1e4, 70, true, &bins, &err), RMAP_OK);
    assert_bins(&bins);
    assert_true(fabs(bins.edge[10] / 1e-2 - 1.0) < 1e-12);
    rmap_bins_fini(&bins);
    assert_int_equal(rmap_bins_round(0.1234, 0.9877, 50, &bins, &err), RMAP_OK);
    assert_bins(&bins);
    assert_true(bins.edge[0] == 0.12 && bins.edge[bins.n] == 1.0 && bins.n == 44);
    rmap_bins_fini(&bins);
    assert_int_equal(rmap_bins_round(3.0, 3.0, 50, &bins, &err), RMAP_OK);
    assert_bins(&bins);
    assert_true(bins.edge[0] <= 3.0 && bins.edge[bins.n] >= 3.0);
    rmap_bins_fini(&bins);
    assert_int_equal(rmap_bins_whole(2, 7, 100, &bins, &err), RMAP_OK);
    assert_bins(&bins);
    assert_true(bins.n == 6 && bins.edge[0] == 1.5 && bins.edge[6] == 7.5);
    rmap_bins_fini(&bins);
    assert_int_equal(rmap_bins_between((double[]){0, 1, 10}, 2, &bins, &err), RMAP_OK);
    assert_bins(&bins);
    rmap_bins_fini(&bins);
    assert_int_equal(rmap_bins_between((double[]){0, 0}, 1, &bins, &err), RMAP_USAGE);
    assert_int_equal(rmap_alloc_live(), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(powers_are_summed_in_any_order),
        cmocka_unit_test(two_points_have_the_moments_of_two_points),
        cmocka_unit_test(bins_hold_what_their_edges_say),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
