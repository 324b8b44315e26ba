/* SPDX-License-Identifier: MIT
 *
 * Refractive indices against a published listing (CODE V's 1981 double Gauss, six decimals) and
 * the catalogue's nd and Vd.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <strings.h>

#include <cmocka.h>

#include "near.h"
#include "optics/dispersion.h"

static double index_at(const char *name, double wavelength_nm)
{
    const struct rmap_glass *glass = rmap_glass_find(name);
    assert_non_null(glass);
    return rmap_sellmeier_index(&glass->sellmeier, wavelength_nm);
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

static void exact_values(void **state)
{
    (void)state;
    assert_near(index_at("N-BK7", 656.3), 1.51432148995205, 1e-13);
    assert_near(index_at("N-BK7", 587.6), 1.51679843790501, 1e-13);
    assert_near(index_at("N-BK7", 486.1), 1.5223786557709, 1e-13);
    assert_near(index_at("n-sf11", 587.6), 1.78471410302463, 1e-13);
}

/* nd to the catalogue's five decimals, Abbe number (nd - 1) / (nF - nC) to its two. */
static void catalogue(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        double nd, vd;
    } row[] = {
        {"N-BK7", 1.51680, 64.17},   {"N-SK16", 1.62041, 60.32},  {"N-SF2", 1.64769, 33.82},
        {"N-SF14", 1.76182, 26.53},  {"N-SF5", 1.67271, 32.25},   {"N-SF10", 1.72828, 28.53},
        {"N-BAK4", 1.56883, 55.98},  {"N-BAF10", 1.67003, 47.11}, {"N-LASF9", 1.85025, 32.17},
        {"N-FK51A", 1.48656, 84.47}, {"F2", 1.62004, 36.37},      {"N-SF6", 1.80518, 25.36},
        {"N-SF11", 1.78472, 25.68}};
    for (size_t i = 0; i < sizeof row / sizeof row[0]; i++) {
        double nd = index_at(row[i].name, 587.5618);
        double nf = index_at(row[i].name, 486.1327), nc = index_at(row[i].name, 656.2725);
        assert_near(nd, row[i].nd, 6e-6);
        assert_near((nd - 1.0) / (nf - nc), row[i].vd, 0.0101);
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

static void bad_wavelengths_are_nan(void **state)
{
    (void)state;
    struct rmap_sellmeier pole = {1, {1.0}, {0.25}}; /* at 500 nm exactly */
    assert_true(isnan(rmap_sellmeier_index(&pole, 500.0)));
    assert_true(isnan(rmap_sellmeier_index(&pole, 400.0))); /* n^2 < 1 */
    assert_true(rmap_sellmeier_index(&pole, 600.0) > 1.0);
}

static void the_list_is_sorted_and_complete(void **state)
{
    (void)state;
    const struct rmap_glass *glass, *previous = NULL;
    for (size_t i = 0; (glass = rmap_glass_at(i)); i++) {
        if (previous)
            assert_true(strcasecmp(previous->name, glass->name) < 0);
        assert_ptr_equal(rmap_glass_find(glass->name), glass);
        assert_true(strlen(glass->source) > 10);
        assert_true(glass->from_nm < glass->to_nm);
        for (double nm = glass->from_nm; nm <= glass->to_nm; nm += 10.0)
            assert_true(rmap_sellmeier_index(&glass->sellmeier, nm) > 1.1);
        previous = glass;
    }
    assert_null(rmap_glass_find("unobtainium"));
}

int main(void)
{
    const struct CMUnitTest test[] = {
        cmocka_unit_test(codev_listing),
        cmocka_unit_test(exact_values),
        cmocka_unit_test(catalogue),
        cmocka_unit_test(crystals),
        cmocka_unit_test(bad_wavelengths_are_nan),
        cmocka_unit_test(the_list_is_sorted_and_complete),
    };
    return cmocka_run_group_tests_name("dispersion", test, NULL, NULL);
}
