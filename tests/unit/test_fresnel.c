/* SPDX-License-Identifier: MIT
 *
 * Fresnel's formulas against closed forms and published values.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/vec.h"
#include "near.h"
#include "optics/fresnel.h"

#define DEG (RMAP_PI / 180.0)

/* ((n - 1) / (n + 1))^2 */
static void normal_incidence(void **state)
{
    (void)state;
    const double n[] = {1.5, 1.5168, 2.4, 1.333};
    const double expected[] = {0.04, 0.0421645625945458, 0.169550173010381, 0.0203731878419714};
    for (int i = 0; i < 4; i++) {
        struct rmap_fresnel f = rmap_fresnel_dielectric(1.0, n[i], 1.0);
        assert_near(f.rs, expected[i], 1e-14);
        assert_near(f.rp, expected[i], 1e-14);
        assert_true(f.cos_t == 1.0 && !f.total);
        f = rmap_fresnel_dielectric(n[i], 1.0, 1.0);
        assert_near(f.rs, expected[i], 1e-14);
    }
}

/* Amplitudes at 45 degrees into n = 1.5 and at 10 degrees out of it (Mitsuba 3's published test
 * values). */
static void oblique_incidence(void **state)
{
    (void)state;
    struct rmap_fresnel f = rmap_fresnel_dielectric(1.0, 1.5, cos(45.0 * DEG));
    assert_near(sqrt(f.rs), 0.303337045290423, 1e-12);
    assert_near(sqrt(f.rp), 0.0920133630455244, 1e-12);
    assert_near(0.5 * (f.rs + f.rp), 0.050239911012236, 1e-12);
    assert_near(acos(f.cos_t) / DEG, 28.1255057020557, 1e-10);
    f = rmap_fresnel_dielectric(1.5, 1.0, cos(10.0 * DEG));
    assert_near(sqrt(f.rs), 0.20949431963852, 1e-12);
    assert_near(sqrt(f.rp), 0.190467971977794, 1e-12);
    assert_near(acos(f.cos_t) / DEG, 15.098086605159, 1e-10);
}

static void brewster(void **state)
{
    (void)state;
    struct rmap_fresnel f = rmap_fresnel_dielectric(1.0, 1.5, cos(atan(1.5)));
    assert_near(f.rp, 0.0, 1e-30);
    assert_near(f.rs, 0.14792899408284, 1e-13);
}

static void total_reflection(void **state)
{
    (void)state;
    double critical = asin(1.0 / 1.5);
    assert_near(critical / DEG, 41.8103148957786, 1e-12);
    struct rmap_fresnel f = rmap_fresnel_dielectric(1.5, 1.0, cos(critical + 1e-9));
    assert_true(f.total && f.rs == 1.0 && f.rp == 1.0 && f.cos_t == 0.0);
    f = rmap_fresnel_dielectric(1.5, 1.0, cos(critical - 1e-9));
    assert_true(!f.total && f.rs < 1.0 && f.cos_t > 0.0);
}

static void degenerate_cases(void **state)
{
    (void)state;
    struct rmap_fresnel f = rmap_fresnel_dielectric(1.3, 1.3, 0.0);
    assert_true(f.rs == 0.0 && f.rp == 0.0 && !f.total);
    f = rmap_fresnel_dielectric(1.0, 1.5, 0.0);
    assert_near(f.rs, 1.0, 1e-15);
    assert_near(f.rp, 1.0, 1e-15);
}

/* A metal without absorption is a dielectric, at every angle, total reflection included. */
static void metal_becomes_dielectric(void **state)
{
    (void)state;
    const double pair[][2] = {{1.0, 1.5}, {1.5, 1.0}, {1.33, 1.7}};
    for (int k = 0; k < 3; k++)
        for (int i = 0; i <= 100; i++) {
            double c = i / 100.0;
            struct rmap_fresnel f = rmap_fresnel_dielectric(pair[k][0], pair[k][1], c);
            assert_near(rmap_fresnel_metal(pair[k][0], pair[k][1], 0.0, c), 0.5 * (f.rs + f.rp),
                        1e-13);
        }
}

/* ((n - 1)^2 + k^2) / ((n + 1)^2 + k^2) with Johnson & Christy's silver at 582 nm; at 60 degrees
 * against amplitudes in complex arithmetic, done here by hand. */
static void silver(void **state)
{
    (void)state;
    double n = 0.05, k = 3.858;
    assert_near(rmap_fresnel_metal(1.0, n, k, 1.0),
                ((n - 1) * (n - 1) + k * k) / ((n + 1) * (n + 1) + k * k), 1e-15);
    double c = 0.5, re = n * n - k * k - 0.75, im = 2 * n * k; /* m^2 - sin^2 */
    double mod = sqrt(re * re + im * im);
    double q_re = sqrt((mod + re) / 2), q_im = sqrt((mod - re) / 2); /* its root */
    double rs = ((c - q_re) * (c - q_re) + q_im * q_im) / ((c + q_re) * (c + q_re) + q_im * q_im);
    double m2_re = (n * n - k * k) * c, m2_im = 2 * n * k * c; /* m^2 cos */
    double rp = (pow(m2_re - q_re, 2) + pow(m2_im - q_im, 2)) /
                (pow(m2_re + q_re, 2) + pow(m2_im + q_im, 2));
    assert_near(rmap_fresnel_metal(1.0, n, k, c), 0.5 * (rs + rp), 1e-13);
    assert_near(rmap_fresnel_metal(1.0, n, k, 0.0), 1.0, 1e-15);
}

int main(void)
{
    const struct CMUnitTest test[] = {
        cmocka_unit_test(normal_incidence), cmocka_unit_test(oblique_incidence),
        cmocka_unit_test(brewster),         cmocka_unit_test(total_reflection),
        cmocka_unit_test(degenerate_cases), cmocka_unit_test(metal_becomes_dielectric),
        cmocka_unit_test(silver),
    };
    return cmocka_run_group_tests_name("fresnel", test, NULL, NULL);
}
