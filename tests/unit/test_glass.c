/* SPDX-License-Identifier: MIT
 *
 * The catalogue's materials: every one against its published nd and vd, some against other sources,
 * names, formulas, tables and absorption.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "near.h"
#include "optics/catalogue.h"

static struct rmap_glass named(const char *name)
{
    struct rmap_glass glass = {0};
    char choices[200];
    if (rmap_glass_find(name, &glass, choices, sizeof choices) != RMAP_GLASS_FOUND)
        fail_msg("no glass %s", name);
    return glass;
}

static double index_at(const char *name, double wavelength_nm)
{
    const struct rmap_glass glass = named(name);
    return rmap_glass_index(&glass, wavelength_nm);
}

static void codev_listing(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        double n[3];
    } listed[] = {{"N-SSK2", {1.618769, 1.622292, 1.630455}},
                  {"N-SK2", {1.604134, 1.607379, 1.61486}},
                  {"F5", {1.598744, 1.603417, 1.614617}},
                  {"N-SK16", {1.617271, 1.620408, 1.627559}}};
    const double line_nm[3] = {656.3, 587.6, 486.1};
    for (int g = 0; g < 4; g++)
        for (int i = 0; i < 3; i++)
            assert_near(index_at(listed[g].name, line_nm[i]), listed[g].n[i], 6e-7);
}

/* By the derivatives of the formulas (Sellmeier coefficients of Malitson 1965 and of SCHOTT), and
 * of a cubic spline through rows of 50 nm; against differences of the index for the other formulas.
 */
static void group_indices(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        double nm, group;
    } known[] = {{"N-BK7", 400.0, 1.584114},
                 {"N-BK7", 500.0, 1.554659},
                 {"N-BK7", 587.56, 1.541360},
                 {"N-BK7", 700.0, 1.531681}};
    struct rmap_glass silica = {.formula = 2,
                                .n_coefficient = 7,
                                .coefficient = {0.0, 0.6961663, 0.0684043 * 0.0684043, 0.4079426,
                                                0.1162414 * 0.1162414, 0.8974794,
                                                9.896161 * 9.896161}};
    static const double nm[4] = {300.0, 400.0, 589.3, 600.0};
    static const double group[4] = {1.572412, 1.513769, 1.478992, 1.478024};
    struct rmap_glass table = {.formula = 0, .linear = true};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        const struct rmap_glass glass = named(known[i].name);
        assert_near(rmap_glass_group_index(&glass, known[i].nm), known[i].group, 6e-7);
    }
    for (double row = 200.0; row <= 1000.0; row += 50.0) {
        table.index.wavelength_nm[table.index.n] = row;
        table.index.value[table.index.n++] = rmap_glass_index(&silica, row);
    }
    for (size_t i = 0; i < 4; i++) {
        assert_near(rmap_glass_group_index(&silica, nm[i]), group[i], 6e-7);
        assert_near(rmap_glass_group_index(&table, nm[i]), group[i], 5e-5);
    }
    assert_near(rmap_glass_group_index(&table, 100.0), rmap_glass_index(&table, 100.0), 0.0);
    for (int formula = 1; formula <= 5; formula++) {
        struct rmap_glass glass = {
            .formula = formula,
            .n_coefficient = formula == 4 ? 13 : 5,
            .coefficient = {formula < 3 ? 0.1 : 2.2, formula == 5 ? 0.02 : 1.1,
                            formula == 3   ? 2.0
                            : formula == 5 ? -2.0
                                           : 0.12,
                            0.01, formula == 3 || formula == 5 ? -4.0 : 0.3}};
        static const double general[13] = {2.1, 0.02, 2.0,  0.2,  2.0,    0.01, 0.0,
                                           0.3, 2.0,  0.01, -2.0, -0.003, 2.0};
        if (formula == 4)
            memcpy(glass.coefficient, general, sizeof general);
        const double at = 620.0, h = 0.05;
        const double slope =
            (8.0 * (rmap_glass_index(&glass, at + h) - rmap_glass_index(&glass, at - h)) -
             (rmap_glass_index(&glass, at + 2 * h) - rmap_glass_index(&glass, at - 2 * h))) /
            (12.0 * h);
        assert_near(rmap_glass_group_index(&glass, at), rmap_glass_index(&glass, at) - at * slope,
                    1e-9);
    }
}

static void exact_values(void **state)
{
    (void)state;
    assert_near(index_at("N-BK7", 656.3), 1.51432148995205, 1e-13);
    assert_near(index_at("N-BK7", 587.6), 1.51679843790501, 1e-13);
    assert_near(index_at("N-BK7", 486.1), 1.5223786557709, 1e-13);
    assert_near(index_at("n-sf11", 587.6), 1.78471410302463, 1e-13);
}

/* Five decimals of nd and two of vd are published, by SUMITA less, and of coefficients that miss
 * its own nd by up to 4e-5; BOROFLOAT 33 has three decimals. */
static void every_nd_and_vd(void **state)
{
    (void)state;
    struct rmap_catalogue place = {0};
    struct rmap_glass glass;
    size_t n = 0, n_published = 0, wrong = 0;
    for (; rmap_catalogue_next(&place); n++) {
        rmap_catalogue_read(&place, &glass);
        if (isnan(glass.nd))
            continue;
        n_published++;
        const bool loose = strcmp(glass.group, "SUMITA") == 0;
        const bool three = strcmp(glass.name, "BOROFLOAT33") == 0;
        double nd = rmap_glass_index(&glass, RMAP_LINE_D_NM), vd = rmap_glass_abbe(&glass);
        double far = three ? 5e-4 : loose ? 4e-5 : 1e-5;
        double most = three ? 0.7 : loose ? 0.25 : 6e-4 * glass.vd;
        if (fabs(nd - glass.nd) <= far && fabs(vd - glass.vd) <= most)
            continue;
        print_error("%s %s: nd %.6f, published %.6f; vd %.4f, published %.4f\n", glass.group,
                    glass.name, nd, glass.nd, vd, glass.vd);
        wrong++;
    }
    assert_int_equal(wrong, 0);
    assert_true(n > 1700 && n_published > 1600);
}

static void every_line_is_understood(void **state)
{
    (void)state;
    struct rmap_catalogue place = {0};
    struct rmap_glass glass, again;
    char choices[200], name[64];
    while (rmap_catalogue_next(&place)) {
        rmap_catalogue_read(&place, &glass);
        (void)snprintf(name, sizeof name, "%s:%s", glass.group, glass.name);
        assert_int_equal(rmap_glass_find(name, &again, choices, sizeof choices), RMAP_GLASS_FOUND);
        assert_string_equal(again.name, glass.name); /* so names differ within a group */
        assert_true(strlen(glass.source) > 10 && strlen(glass.source) < sizeof glass.source - 1);
        assert_true(glass.from_nm < glass.to_nm);
        assert_true(glass.formula ? glass.n_coefficient % 2 == 1 : glass.index.n > 1);
        assert_true(glass.index.n < RMAP_GLASS_ROWS_MAX);
        const bool metal = strcmp(glass.group, "metal") == 0;
        for (int i = 0; i <= 20; i++) {
            double nm = glass.from_nm + (glass.to_nm - glass.from_nm) * i / 20.0;
            double n = rmap_glass_index(&glass, nm);
            if (!(n > (metal ? 0.01 : 0.2) && n < (metal ? 200.0 : 5.0)))
                fail_msg("%s has index %g at %g nm", name, n, nm);
        }
        const struct rmap_glass_table *table[] = {&glass.index, &glass.extinction};
        for (int t = 0; t < 2; t++)
            for (size_t i = 1; i < table[t]->n; i++)
                assert_true(table[t]->wavelength_nm[i - 1] < table[t]->wavelength_nm[i]);
        for (size_t i = 0; i < glass.extinction.n; i++)
            assert_true(glass.extinction.value[i] >= 0.0);
    }
}

/* Crystals, whose coefficients are printed unsquared: values of the papers' own tables. */
static void crystals(void **state)
{
    (void)state;
    assert_near(index_at("fused-silica", 587.561), 1.458464, 1.5e-6); /* Malitson 1965, nd */
    assert_near(index_at("SiO2", 1060.0), 1.449681, 1e-5);
    assert_near(index_at("CaF2", 589.0), 1.43383, 2e-5); /* Malitson 1963 */
    assert_near(index_at("Al2O3", 587.6), 1.76823, 2e-4);
    assert_near(index_at("MgF2", 589.0), 1.37774, 1e-4);
}

/* One of each kind: by hand from the line of the file. */
static void formulas(void **state)
{
    (void)state;
    assert_near(
        index_at("HOYA BSC7", 1000.0),
        sqrt(2.2702566 - 0.0091988101 + 0.011609706 - 7.6123911e-5 + 2.8558727e-5 - 1.2566486e-6),
        1e-15);
    assert_near(index_at("MgO", 1000.0),
                sqrt(2.956362 + 0.0219577 / (1.0 - 0.01428322) - 0.01062387 - 2.04968e-5), 1e-15);
    assert_near(index_at("ZnS", 1000.0),
                sqrt(8.393 + 0.14383 / (1.0 - 0.2421 * 0.2421) + 4430.99 / (1.0 - 36.71 * 36.71)),
                1e-14);
    assert_near(index_at("soda-lime", 500.0), 1.513 - 0.003169 * 0.25 + 0.003962 * 4.0, 1e-15);
    assert_near(index_at("Ag", 1937.0), 0.24, 1e-15); /* beyond its end, too */
    assert_near(index_at("Ag", 2500.0), 0.24, 1e-15);
}

/* LZOS publishes indices alone: its K8 is BK7 but for the fifth decimal. */
static void tables(void **state)
{
    (void)state;
    const struct rmap_glass k8 = named("LZOS K8"), bk7 = named("N-BK7");
    assert_int_equal(k8.formula, 0);
    assert_near(rmap_glass_index(&k8, RMAP_LINE_D_NM), 1.51637, 2e-5);
    assert_near(rmap_glass_abbe(&k8), 64.05, 0.1);
    const double off = rmap_glass_index(&k8, 600.0) - rmap_glass_index(&bk7, 600.0);
    for (double nm = 400.0; nm < 1500.0; nm += 7.0)
        assert_near(rmap_glass_index(&k8, nm) - rmap_glass_index(&bk7, nm), off, 2e-4);
}

static void bad_wavelengths_are_nan(void **state)
{
    (void)state;
    struct rmap_glass pole = {.formula = 2, .n_coefficient = 3, .coefficient = {0.0, 1.0, 0.25}};
    assert_true(isnan(rmap_glass_index(&pole, 500.0)));
    assert_true(isnan(rmap_glass_index(&pole, 400.0))); /* n^2 < 1 */
    assert_true(rmap_glass_index(&pole, 600.0) > 1.0);
}

/* The data sheet of N-BK7 (SCHOTT 2017): internal transmittance of 25 and of 10 mm. */
static void absorption(void **state)
{
    (void)state;
    const struct rmap_glass bk7 = named("N-BK7"), ball = named("N-FK58"), tab = named("LZOS K8");
    assert_near(rmap_glass_transmittance(&bk7, 400.0, 25.0), 0.992, 1e-12);
    assert_near(rmap_glass_transmittance(&bk7, 400.0, 10.0), 0.997, 5e-4);
    assert_near(rmap_glass_transmittance(&bk7, 2325.0, 10.0), 0.793, 5e-4);
    assert_near(rmap_glass_extinction(&bk7, 400.0), 1.0227e-8, 5e-13); /* the database's */
    assert_true(isnan(rmap_glass_transmittance(&bk7, 250.0, 10.0)));
    assert_true(ball.extinction.n > 10);
    assert_true(tab.extinction.n == 0 && isnan(rmap_glass_transmittance(&tab, 500.0, 10.0)));
    assert_true(rmap_glass_extinction(&tab, 500.0) == 0.0);
}

static void names(void **state)
{
    (void)state;
    struct rmap_glass glass;
    char choices[200];
    static const char *const same[] = {"N-LAK8", "n-lak8", "SCHOTT N-LAK8", "schott:N-lak8"};
    for (size_t i = 0; i < sizeof same / sizeof *same; i++) {
        glass = named(same[i]);
        assert_string_equal(glass.name, "N-LAK8");
        assert_string_equal(glass.group, "SCHOTT");
    }
    glass = named("F2"); /* of CDGM and HIKARI, too */
    assert_string_equal(glass.group, "SCHOTT");
    glass = named("CDGM F2");
    assert_near(rmap_glass_index(&glass, RMAP_LINE_D_NM), 1.61293, 1e-5);
    assert_int_equal(rmap_glass_find("E-F2", &glass, choices, sizeof choices), RMAP_GLASS_SEVERAL);
    assert_string_equal(choices, "HOYA E-F2, HIKARI E-F2");
    static const char *const none[] = {"unobtainium",  "",    "SCHOTT", "SCHOTT ", "SCHOTT E-F2",
                                       "N-BK7 1.5168", "N-BK"};
    for (size_t i = 0; i < sizeof none / sizeof *none; i++)
        assert_int_equal(rmap_glass_find(none[i], &glass, choices, sizeof choices),
                         RMAP_GLASS_UNKNOWN);
}

int main(void)
{
    const struct CMUnitTest test[] = {
        cmocka_unit_test(codev_listing),
        cmocka_unit_test(exact_values),
        cmocka_unit_test(group_indices),
        cmocka_unit_test(every_nd_and_vd),
        cmocka_unit_test(every_line_is_understood),
        cmocka_unit_test(crystals),
        cmocka_unit_test(formulas),
        cmocka_unit_test(tables),
        cmocka_unit_test(bad_wavelengths_are_nan),
        cmocka_unit_test(absorption),
        cmocka_unit_test(names),
    };
    return cmocka_run_group_tests_name("glass", test, NULL, NULL);
}
