/* SPDX-License-Identifier: MIT
 *
 * The promise: thin films reflect, pass and absorb what published and textbook stacks do.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>

#include "base/rng.h"
#include "base/vec.h"
#include "optics/fresnel.h"
#include "optics/thin_film.h"

static void near_to(double is, double want, double within)
{
    if (!(fabs(is - want) <= within))
        fail_msg("%.16g, not %.16g (off by %.2g)", is, want, is - want);
}

/* S. Byrnes, tmm (tests.py, basic_test): 2 + 4i and 3 + 0.3i of 2 and 3 at wavelength 100, on
 * 1 + 0.1i. */
static void test_published_stack(void **state)
{
    const struct rmap_thin_film_layer layer[] = {{2, 4, 0.02}, {3, 0.3, 0.03}};
    const struct rmap_thin_film_shares s =
        rmap_thin_film_shares(layer, 2, false, 1, 1, 0.1, cos(0.1));
    (void)state;
    near_to(s.rs, 0.372732088391395, 1e-12);
    near_to(s.ts, 0.226044912470793, 1e-12);
    near_to(s.rp, 0.37016110373045, 1e-12);
    near_to(s.tp, 0.22824374314132, 1e-12);
}

/* Macleod: MgF2 on 1.52 at 550 nm, at 0, 30, 45, 60 degrees, and from 400 to 700 nm. */
static void test_quarter_wave(void **state)
{
    static const double rs[] = {0.0126007902146303, 0.0206357526841605, 0.0400477184418068,
                                0.100818426939448};
    static const double rp[] = {0.0126007902146303, 0.00701741609757578, 0.00135573929347619,
                                0.00604933794797111};
    static const double angle[] = {0, 30, 45, 60};
    static const double over[] = {0.0220525153097595, 0.0162043016042977, 0.0133568264460199,
                                  0.0131272607864446, 0.0159619687298839};
    (void)state;
    for (int i = 0; i < 4; i++) {
        const struct rmap_thin_film_layer layer = {1.38, 0, 0.25 / 1.38};
        const struct rmap_thin_film_shares s =
            rmap_thin_film_shares(&layer, 1, false, 1, 1.52, 0, cos(angle[i] * RMAP_PI / 180.0));
        near_to(s.rs, rs[i], 1e-10);
        near_to(s.rp, rp[i], 1e-10);
    }
    static const double nm[] = {400, 450, 500, 600, 700};
    for (int i = 0; i < 5; i++) {
        const struct rmap_thin_film_layer layer = {1.38, 0, 0.25 / 1.38 * 550.0 / nm[i]};
        near_to(rmap_thin_film_shares(&layer, 1, false, 1, 1.52, 0, 1.0).rs, over[i], 1e-10);
    }
}

/* (HL)^8 and (HL)^8 H of 2.35 and 1.38 on 1.52: a quarter wave each. Its stop band ends where
 * cos^2 of the phase is ((H - L) / (H + L))^2: 471.10 and 660.65 nm for 550. */
static void test_bragg(void **state)
{
    struct rmap_thin_film_layer layer[17];
    (void)state;
    for (int i = 0; i < 17; i++) {
        const double n = i % 2 ? 1.38 : 2.35;
        layer[i] = (struct rmap_thin_film_layer){n, 0, 0.25 / n};
    }
    near_to(rmap_thin_film_shares(layer, 16, false, 1, 1.52, 0, 1.0).rs, 0.99947388, 5e-9);
    near_to(rmap_thin_film_shares(layer, 17, false, 1, 1.52, 0, 1.0).rs, 0.99977986, 5e-9);
}

/* prysm's tests: 0.15 um MgF2, and MgF2, ZrO2, CeF3 on Corning 7980, thicknesses as written there.
 */
static void test_corning(void **state)
{
    const double um = 0.587725, n = 1.458461;
    const struct rmap_thin_film_layer one = {1.3698, 0, 0.15 / um};
    const struct rmap_thin_film_layer three[] = {
        {1.3698, 0, 0.25}, {2.1588, 0, 0.5}, {1.6290, 0.0034836, 0.25}};
    (void)state;
    near_to(rmap_thin_film_shares(&one, 1, false, 1, n, 0, 1.0).rs, 0.0223316103033495, 1e-10);
    near_to(rmap_thin_film_shares(three, 3, false, 1, n, 0, 1.0).rs, 0.00260880196056235, 1e-10);
}

static void test_no_layers(void **state)
{
    (void)state;
    for (int i = 0; i <= 1000; i++) {
        const double cos_i = i / 1000.0;
        for (int k = 0; k < 3; k++) {
            const double n1 = (const double[]){1.0, 1.5168, 1.3}[k],
                         n2 = (const double[]){1.5168, 1.0, 1.3}[k];
            const struct rmap_fresnel f = rmap_fresnel_dielectric(n1, n2, cos_i);
            const struct rmap_thin_film_shares s =
                rmap_thin_film_shares(NULL, 0, false, n1, n2, 0, cos_i);
            if (n1 == n2 && cos_i == 0.0)
                continue; /* light that goes along the boundary meets none */
            assert_int_equal(s.total, f.total);
            near_to(s.rs, f.rs, 1e-14);
            near_to(s.rp, f.rp, 1e-14);
            near_to(s.rs + s.ts, 1.0, 1e-14);
            near_to(s.rp + s.tp, 1.0, 1e-14);
        }
    }
}

/* Any stack: nothing is gained, nothing lost without absorption, as much passes either way at the
 * angles of Snell; a thick absorber passes nothing and harms nothing. */
static void test_laws(void **state)
{
    (void)state;
    for (uint64_t k = 0; k < 3000; k++) {
        struct rmap_thin_film_layer layer[12];
        double u[4];
        const size_t n = k % 12;
        const bool absorbs = k % 3 == 0;
        for (size_t i = 0; i < n; i++) {
            rmap_rng(3, k, (uint32_t)i, 0, u);
            layer[i] = (struct rmap_thin_film_layer){1.0 + 2.0 * u[0], absorbs ? 3.0 * u[1] : 0.0,
                                                     2.0 * u[2]};
        }
        rmap_rng(3, k, 100, 0, u);
        const double n1 = 1.0 + u[0], n2 = 1.0 + u[1], cos_1 = 0.1 + 0.9 * u[2];
        const double sin_2 = n1 * sqrt(1.0 - cos_1 * cos_1) / n2;
        const struct rmap_thin_film_shares a =
            rmap_thin_film_shares(layer, n, false, n1, n2, 0, cos_1);
        assert_true(a.rs + a.ts <= 1.0 + 1e-12 && a.rp + a.tp <= 1.0 + 1e-12);
        assert_true(a.rs >= 0.0 && a.rp >= 0.0 && a.ts >= 0.0 && a.tp >= 0.0);
        assert_int_equal(a.total, sin_2 >= 1.0);
        if (!absorbs) {
            near_to(a.rs + a.ts, 1.0, 1e-12);
            near_to(a.rp + a.tp, 1.0, 1e-12);
        }
        if (sin_2 >= 0.99) /* the cosine beyond has lost its digits */
            continue;
        const struct rmap_thin_film_shares b =
            rmap_thin_film_shares(layer, n, true, n2, n1, 0, sqrt(1.0 - sin_2 * sin_2));
        near_to(b.ts, a.ts, 1e-12);
        near_to(b.tp, a.tp, 1e-12);
        if (!absorbs) {
            near_to(b.rs, a.rs, 1e-12);
            near_to(b.rp, a.rp, 1e-12);
        }
    }
    const struct rmap_thin_film_layer thick = {1.5, 2.0, 1e4};
    const struct rmap_thin_film_shares dark =
        rmap_thin_film_shares(&thick, 1, false, 1, 1.5, 0, 0.7);
    assert_true(dark.ts == 0.0 && dark.tp == 0.0 && dark.rs > 0.0 && dark.rs < 1.0);
}

/* An air gap of a tenth of a wavelength between two prisms at 45 degrees lets light through that a
 * wide one reflects. */
static void test_frustrated(void **state)
{
    const double cos_i = sqrt(0.5);
    double before = 1.0;
    (void)state;
    for (int i = 0; i <= 40; i++) {
        const struct rmap_thin_film_layer gap = {1.0, 0, 0.1 * i};
        const struct rmap_thin_film_shares s =
            rmap_thin_film_shares(&gap, 1, false, 1.5168, 1.5168, 0, cos_i);
        assert_false(s.total);
        assert_true(s.ts <= before + 1e-15);
        near_to(s.rs + s.ts, 1.0, 1e-13);
        before = s.ts;
    }
    assert_true(before < 1e-6);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_published_stack), cmocka_unit_test(test_quarter_wave),
        cmocka_unit_test(test_bragg),           cmocka_unit_test(test_corning),
        cmocka_unit_test(test_no_layers),       cmocka_unit_test(test_laws),
        cmocka_unit_test(test_frustrated)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
