/* SPDX-License-Identifier: MIT
 *
 * Sags against the sums that define them, in long double, against each other where two are the same
 * surface, and their bounds against what they bound.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "base/rng.h"
#include "sag_reference.h"

static double uniform(uint64_t i, int k)
{
    double u[4];
    rmap_rng(7, i, (uint32_t)(k / 4), RMAP_RNG_SURFACE, u);
    return u[k % 4];
}

/* Of all sums at once: every base, 8 of each in turn. */
static struct rmap_sag random_sag(uint64_t i)
{
    static const double conics[] = {0, -1, -2.5, 0.8};
    struct rmap_sag sag = {.base = (enum rmap_sag_base)(i % 3),
                           .curvature = {0.06 * uniform(i, 0) - 0.03, 0.06 * uniform(i, 1) - 0.03},
                           .conic = {conics[i % 4], conics[i / 4 % 4]},
                           .xy_norm = 12,
                           .zernike_norm = 11,
                           .qcon_norm = 10,
                           .qbfs_norm = 10.5};
    if (sag.base == RMAP_SAG_CONIC) {
        sag.curvature[1] = sag.curvature[0];
        sag.conic[1] = sag.conic[0];
    }
    const int which = (int)(i / 3 % 8);
    sag.n_power = which == 0 || which > 5 ? 8 : 0;
    sag.n_xy = which == 1 || which > 5 ? 9 : 0;
    sag.n_zernike = which == 2 || which > 5 ? 10 : 0;
    sag.n_qcon = which == 3 || which > 5 ? 5 : 0;
    sag.n_qbfs = sag.base == RMAP_SAG_CONIC && (which == 4 || which > 5) ? 12 : 0;
    for (int k = 1; k < sag.n_power; k++)
        sag.power[k] = (uniform(i, 8 + k) - 0.5) * pow(10, -k - 1);
    for (int k = 0; k < RMAP_SAG_TERMS; k++) {
        sag.xy[k] = k < rmap_sag_term(9, 0) ? 0.2 * (uniform(i, 40 + k) - 0.5) : 0;
        sag.zernike[k] = k < rmap_sag_term(10, 0) ? 0.05 * (uniform(i, 300 + k) - 0.5) : 0;
    }
    for (int k = 0; k < 12; k++) {
        sag.qcon[k] = uniform(i, 560 + k) - 0.5;
        sag.qbfs[k] = uniform(i, 580 + k) - 0.5;
    }
    return sag;
}

static const struct rmap_aperture circle = {.half = {10, 10}};

/* Of sixth order in h. */
static real slope_of(const struct rmap_sag *sag, real x, real y, bool along_y)
{
    const real h = 1e-3L, weight[] = {45, -9, 1};
    real sum = 0;
    for (int k = 1; k <= 3; k++) {
        const real dx = along_y ? 0 : k * h, dy = along_y ? k * h : 0;
        sum += weight[k - 1] *
               (sag_reference(sag, x + dx, y + dy) - sag_reference(sag, x - dx, y - dy));
    }
    return sum / (60 * h);
}

static void test_values_and_slopes(void **state)
{
    (void)state;
    for (uint64_t i = 0; i < 96; i++) {
        struct rmap_sag sag = random_sag(i);
        const char *wrong = rmap_sag_finish(&sag, &circle);
        if (wrong)
            fail_msg("sag %d: %s", (int)i, wrong);
        for (int k = 0; k < 40; k++) {
            const double r = 9.9 * sqrt(uniform(i, 700 + 2 * k)), phi = 7 * uniform(i, 701 + 2 * k);
            const double x = r * cos(phi), y = r * sin(phi);
            const struct rmap_height at = rmap_sag_profile(&sag, x, y);
            const double off = (double)fabsl(at.z - sag_reference(&sag, x, y)),
                         off_x = (double)fabsl(at.x - slope_of(&sag, x, y, false)),
                         off_y = (double)fabsl(at.y - slope_of(&sag, x, y, true));
            if (off > 1e-13 || off_x > 1e-12 || off_y > 1e-12)
                fail_msg("sag %d at %g %g: z off by %g, slopes by %g and %g", (int)i, x, y, off,
                         off_x, off_y);
        }
    }
}

/* No second difference exceeds the bound, no height the range. */
static void test_bounds(void **state)
{
    (void)state;
    double tightest = HUGE_VAL;
    for (uint64_t i = 0; i < 96; i++) {
        struct rmap_sag sag = random_sag(i);
        double most = 0, bound = 0;
        assert_null(rmap_sag_finish(&sag, &circle));
        for (int k = 0; k < 1500; k++) {
            const double r = 9.98 * sqrt(uniform(i, 700 + 3 * k)),
                         phi = 7 * uniform(i, 701 + 3 * k);
            const double x = r * cos(phi), y = r * sin(phi), way = 7 * uniform(i, 702 + 3 * k);
            const double dx = 1e-4 * cos(way), dy = 1e-4 * sin(way);
            const struct rmap_height a = rmap_sag_profile(&sag, x - dx, y - dy),
                                     b = rmap_sag_profile(&sag, x + dx, y + dy);
            const double bend = fabs((b.x - a.x) * dx + (b.y - a.y) * dy) / 2;
            most = fmax(most, bend);
            bound = rmap_sag_bend(&sag, rmap_vec3(dx, dy, 0), 0, 0, 100);
            if (!(bend <= bound * (1 + 1e-6)))
                fail_msg("sag %d at %g %g: bends by %g, more than %g", (int)i, x, y, bend, bound);
            assert_true(a.z >= sag.low && a.z <= sag.high);
        }
        tightest = fmin(tightest, bound / most);
    }
    assert_true(tightest < 2);
}

/* The slopes of u^2 (1 - u^2) Q_m^bfs are orthonormal over u = cos of even angles (Forbes 2007). */
static void test_q_bfs_is_orthonormal(void **state)
{
    enum { ANGLES = 256, ORDERS = 32 };
    (void)state;
    struct rmap_sag sag[ORDERS];
    memset(sag, 0, sizeof sag);
    for (int m = 0; m < ORDERS; m++) {
        sag[m].qbfs_norm = 1;
        sag[m].n_qbfs = m + 1;
        sag[m].qbfs[m] = 1;
        assert_null(rmap_sag_finish(&sag[m], &(struct rmap_aperture){.half = {1, 1}}));
    }
    for (int m = 0; m < ORDERS; m++)
        for (int n = 0; n <= m; n++) {
            double sum = 0;
            for (int k = 0; k < ANGLES; k++) {
                const double u = cos(0.5 * RMAP_PI * (k + 0.5) / ANGLES);
                sum +=
                    rmap_sag_profile(&sag[m], u, 0).x * rmap_sag_profile(&sag[n], u, 0).x / ANGLES;
            }
            if (fabs(sum - (m == n)) > 1e-11)
                fail_msg("Q_%d, Q_%d: %g", m, n, sum);
        }
    /* as printed there */
    const struct rmap_height at = rmap_sag_profile(&sag[2], 0.6, 0);
    assert_true(fabs(at.z - 0.36 * 0.64 * sqrt(2.0 / 95) * (29 - 4 * 0.36 * (25 - 19 * 0.36))) <
                1e-15);
}

static void test_zernike_orders(void **state)
{
    static const struct {
        enum rmap_zernike_order order;
        int number, n, m;
        double norm;
    } known[] = {{RMAP_ZERNIKE_FRINGE, 1, 0, 0, 1},
                 {RMAP_ZERNIKE_FRINGE, 4, 2, 0, 1},
                 {RMAP_ZERNIKE_FRINGE, 8, 3, -1, 1},
                 {RMAP_ZERNIKE_FRINGE, 9, 4, 0, 1},
                 {RMAP_ZERNIKE_FRINGE, 17, 4, 4, 1},
                 {RMAP_ZERNIKE_FRINGE, 36, 10, 0, 1},
                 {RMAP_ZERNIKE_FRINGE, 37, 12, 0, 1},
                 {RMAP_ZERNIKE_NOLL, 1, 0, 0, 1},
                 {RMAP_ZERNIKE_NOLL, 2, 1, 1, 2},
                 {RMAP_ZERNIKE_NOLL, 5, 2, -2, 2.449489742783178},
                 {RMAP_ZERNIKE_NOLL, 6, 2, 2, 2.449489742783178},
                 {RMAP_ZERNIKE_NOLL, 7, 3, -1, 2.8284271247461903},
                 {RMAP_ZERNIKE_NOLL, 11, 4, 0, 2.23606797749979},
                 {RMAP_ZERNIKE_STANDARD, 0, 0, 0, 1},
                 {RMAP_ZERNIKE_STANDARD, 1, 1, -1, 2},
                 {RMAP_ZERNIKE_STANDARD, 5, 2, 2, 2.449489742783178},
                 {RMAP_ZERNIKE_STANDARD, 12, 4, 0, 2.23606797749979}};
    (void)state;
    int n, m;
    double norm;
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        assert_true(rmap_zernike_term(known[i].order, known[i].number, &n, &m, &norm));
        assert_int_equal(n, known[i].n);
        assert_int_equal(m, known[i].m);
        assert_true(fabs(norm - known[i].norm) < 1e-15);
    }
    assert_false(rmap_zernike_term(RMAP_ZERNIKE_FRINGE, 38, &n, &m, &norm));
    assert_false(rmap_zernike_term(RMAP_ZERNIKE_NOLL, 0, &n, &m, &norm));
    assert_false(rmap_zernike_term(RMAP_ZERNIKE_STANDARD, 231, &n, &m, &norm));
}

#define TERM(degree, k) [(degree) * ((degree) + 1) / 2 + (k)]

/* Pairs that are one surface. */
static void test_equal_surfaces(void **state)
{
    (void)state;
    const struct rmap_sag pair[][2] = {
        {{.base = RMAP_SAG_BICONIC, .curvature = {0.05, 0.05}, .conic = {-0.7, -0.7}},
         {.curvature = {0.05, 0.05}, .conic = {-0.7, -0.7}}},
        {{.base = RMAP_SAG_TOROID, .curvature = {0.05, 0.05}}, {.curvature = {0.05, 0.05}}},
        {{.base = RMAP_SAG_TOROID, .curvature = {0, -0.05}, .power = {0, 0, 0, 1e-4}, .n_power = 4},
         {.base = RMAP_SAG_BICONIC,
          .curvature = {0, -0.05},
          .xy_norm = 1,
          .xy = {TERM(4, 4) = 1e-4},
          .n_xy = 5}},
        /* defocus and spherical of the fringe order: 2 u^2 - 1, 6 u^4 - 6 u^2 + 1 */
        {{.zernike_norm = 8, .zernike = {TERM(2, 1) = 0.3, TERM(4, 2) = 0.1}, .n_zernike = 5},
         {.power = {0, (0.6 - 0.6) / 64, 0, 0.6 / 4096},
          .n_power = 4,
          .xy_norm = 1,
          .xy = {-0.2},
          .n_xy = 1}},
        /* u^4 (Q_0 + Q_1 / 2), Q_1 = 6 u^2 - 5 */
        {{.curvature = {0.02, 0.02}, .qcon_norm = 10, .qcon = {1, 0.5}, .n_qcon = 2},
         {.curvature = {0.02, 0.02}, .power = {0, 0, 0, -1.5e-4, 0, 3e-6}, .n_power = 6}},
        {{.curvature = {0.02, 0.02},
          .xy_norm = 10,
          .xy = {TERM(4, 0) = 0.2, TERM(4, 2) = 0.4, TERM(4, 4) = 0.2},
          .n_xy = 5},
         {.curvature = {0.02, 0.02}, .power = {0, 0, 0, 2e-5}, .n_power = 4}},
    };
    for (size_t i = 0; i < sizeof pair / sizeof pair[0]; i++)
        for (uint64_t k = 1; k < 200; k++) {
            const double x = 14 * uniform(k, 0) - 7, y = 14 * uniform(k, 1) - 7;
            const struct rmap_height a = rmap_sag_profile(&pair[i][0], x, y),
                                     b = rmap_sag_profile(&pair[i][1], x, y);
            if (fabs(a.z - b.z) > 1e-14 || fabs(a.x - b.x) > 1e-15 * 8 ||
                fabs(a.y - b.y) > 1e-15 * 8)
                fail_msg("pair %d at %g %g: %g %g %g", (int)i, x, y, a.z - b.z, a.x - b.x,
                         a.y - b.y);
        }
}

static void test_wrong_numbers(void **state)
{
    (void)state;
    const struct rmap_sag bad[] = {
        {.curvature = {0.1, 0.1}},
        {.curvature = {(double)NAN, 0}},
        {.base = RMAP_SAG_BICONIC, .curvature = {0.08, 0.08}},
        {.base = RMAP_SAG_TOROID, .curvature = {0.1, 0}},
        {.base = RMAP_SAG_TOROID, .curvature = {0, 0.1}},
        {.xy = {1}, .n_xy = 1},
        {.zernike = {(double)INFINITY}, .zernike_norm = 1, .n_zernike = 1},
        {.base = RMAP_SAG_BICONIC, .qbfs_norm = 1, .n_qbfs = 1}};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        struct rmap_sag sag = bad[i];
        if (!rmap_sag_finish(&sag, &circle))
            fail_msg("sag %d is taken", (int)i);
    }
}

/* Points of the chart are found again, and belong. */
static void test_outlines(void **state)
{
    (void)state;
    const struct rmap_aperture all[] = {
        {.half = {3, 3}, .inner = 1},
        {.half = {3, 2}, .at = {1, -4}},
        {.rectangle = true, .half = {5, 2}, .at = {0, 1}, .inner = 0.5}};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++)
        for (int k = 0; k < 400; k++) {
            const double u = (k % 20 + 0.3) / 20, v = (k / 20 + 0.4) / 20;
            double u_found, v_found;
            const struct rmap_vec3 p = rmap_aperture_chart(&all[i], u, v);
            rmap_aperture_find(&all[i], p.x, p.y, &u_found, &v_found);
            assert_true(fabs(u_found - u) < 1e-12 && fabs(v_found - v) < 1e-12);
            assert_true(rmap_aperture_has(&all[i], p.x, p.y));
            assert_true(hypot(p.x, p.y) <= rmap_aperture_far(&all[i]));
            const struct rmap_vec3 rim = rmap_aperture_chart(&all[i], u, -1e-9);
            assert_false(rmap_aperture_has(&all[i], rim.x, rim.y));
            /* a line through the point leaves at the rim */
            double t[2] = {-HUGE_VAL, HUGE_VAL};
            const struct rmap_vec3 d = rmap_vec3(cos(3 * u), sin(3 * u), 0.3);
            assert_true(rmap_aperture_clip(&all[i], p, d, t));
            for (int end = 0; end < 2; end++) {
                const struct rmap_vec3 q = rmap_axpy(t[end], d, p);
                rmap_aperture_find(&all[i], q.x, q.y, &u_found, &v_found);
                assert_true(fabs(v_found) < 1e-13);
                assert_true((rmap_dot(rmap_aperture_outward(&all[i], q.x, q.y), d) > 0) ==
                            (end == 1));
            }
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_values_and_slopes),
                                       cmocka_unit_test(test_bounds),
                                       cmocka_unit_test(test_q_bfs_is_orthonormal),
                                       cmocka_unit_test(test_zernike_orders),
                                       cmocka_unit_test(test_equal_surfaces),
                                       cmocka_unit_test(test_wrong_numbers),
                                       cmocka_unit_test(test_outlines)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
