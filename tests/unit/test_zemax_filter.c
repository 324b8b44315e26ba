/* SPDX-License-Identifier: MIT
 *
 * Filter strings of Zemax: the criterion that each flag becomes, and flags that become none.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "analysis/criterion/criterion.h"
#include "analysis/report/zemax_filter.h"
#include "base/alloc.h"
#include "tests/criterion_scene.h"

static void flags_become_tests(void **state)
{
    (void)state;
    static const struct {
        const char *filter, *criterion;
    } table[] = {
        {"H3", "hit('lens.2')"},
        {"h2", "hit('tube')"},
        {"M6", "not hit('odd n\xc3\xa4me')"},
        {"R5", "hit('mirror', reflect)"},
        {"R0", "hit(*, reflect)"},
        {"T1", "hit('lens.1', transmit)"},
        {"S4", "hit('cover', diffuse)"},
        {"F4", "hit('cover', diffuse)"},
        {"G1", "(hit('lens.1', reflect_specular))"},
        {"G2", "(not all)"}, /* the tube refracts nothing */
        {"G", "(hit('lens.1', reflect_specular) or hit('lens.2', reflect_specular))"},
        {"L2", "path(\".* [^V]@'tube' V*\")"},
        {"O2", "source('sun')"},
        {"O0", "all"},
        {"B0", "event(scatter_volume)"},
        {"X_HITFACE(2,1)", "hit('tube', face 1)"},
        {"X_HITFACE( 2 , 1 )", "hit('tube', face 1)"},
        {"X_HIT(2,3)", "hit('tube') == 3"},
        {"!X_HIT( 1 , 0 ) & H2", "not hit('lens.1') == 0 and hit('tube')"},
        {"H3 & R5 & !G1", "hit('lens.2') and hit('mirror', reflect) and not "
                          "(hit('lens.1', reflect_specular))"},
        {"(H1 & H2 & !R6) | M5", "(hit('lens.1') and hit('tube') and not "
                                 "hit('odd n\xc3\xa4me', reflect)) or not hit('mirror')"},
        {"H1|H2&H3", "hit('lens.1') or hit('tube') and hit('lens.2')"},
        {"!!H1", "hit('lens.1')"},
        {"!(H1|H2)", "not (hit('lens.1') or hit('tube'))"},
        {"H1^H2", "((hit('lens.1')) and not (hit('tube')) or not (hit('lens.1')) and "
                  "(hit('tube')))"},
    };
    struct test_scene t;
    test_scene_init(&t);
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        char *text = NULL;
        struct rmap_criterion *criterion = NULL;
        struct rmap_error err = {0};
        if (rmap_zemax_translate(table[i].filter, &t.scene, &text, &err) != RMAP_OK)
            fail_msg("%s\n%s", table[i].filter, err.text);
        assert_string_equal(text, table[i].criterion);
        assert_int_equal(rmap_criterion_compile(text, &t.scene, &criterion, &err), RMAP_OK);
        rmap_criterion_destroy(criterion);
        rmap_free(text);
    }
    assert_int_equal(rmap_alloc_live(), 0);
}

static void wavelengths_are_the_scene_s(void **state)
{
    (void)state;
    struct test_scene t;
    struct rmap_error err = {0};
    char *text = NULL;
    test_scene_init(&t);
    assert_int_equal(rmap_zemax_translate("W2", &t.scene, &text, &err), RMAP_INPUT);
    assert_non_null(strstr(err.text, "the scene has colours, no wavelengths"));
    t.scene.channels = (struct rmap_channels){RMAP_COLOUR_SPECTRAL, 3, {486.13, 587.56, 656.27}};
    assert_int_equal(rmap_zemax_translate("W2", &t.scene, &text, &err), RMAP_OK);
    assert_string_equal(text, "wavelength == 587.55999999999995");
    rmap_free(text);
    assert_int_equal(rmap_zemax_translate("W4", &t.scene, &text, &err), RMAP_INPUT);
    assert_non_null(strstr(err.text, "there is no wavelength 4: the scene has 3"));
}

static void what_cannot_be_said_is_named(void **state)
{
    (void)state;
    static const struct {
        const char *filter, *message;
    } table[] = {
        {"", "zemax:1:1: error: the filter is empty"},
        {"H1 & D3", "zemax:1:6: error: flag D3 cannot be said: diffraction is no event here"},
        {"E1", "flag E1 cannot be said"},
        {"J2", "flag J2 cannot be said: it changes intensities"},
        {"B2", "flag B2 cannot be said: volume scattering is recorded without an object"},
        {"Z1", "flag Z1 cannot be said"},
        {"X1", "flag X1 cannot be said"},
        {"X_GHOST(1,2)", "flag X_GHOST(1,2 cannot be said"},
        {"Q7", "flag Q7 cannot be said"},
        {"H7", "zemax:1:1: error: there is no object 7: the scene has 6\n  H7\n  ^~"},
        {"H", "flag H needs the number of an object"},
        {"H0", "objects are numbered from 1"},
        {"H99999999999999999999", "there is no object"},
        {"O3", "there is no source 3: the scene has 2"},
        {"H1 H2", "zemax:1:4: error: expected '&', '|', '^' or the end"},
        {"H1 &", "zemax:1:5: error: expected a flag such as H3, found the end"},
        {"(H1", "zemax:1:1: error: this parenthesis is never closed"},
        {"H1)", "zemax:1:3: error: expected '&'"},
        {"&H1", "zemax:1:1: error: expected a flag such as H3, '!' or '('"},
        {"X_HITFACE(1)", "expected X_HITFACE(object, face)"},
        {"\xff", "this is not UTF-8 text"},
    };
    struct test_scene t;
    test_scene_init(&t);
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        struct rmap_error err = {0};
        char *text = NULL;
        assert_int_equal(rmap_zemax_translate(table[i].filter, &t.scene, &text, &err), RMAP_INPUT);
        if (!strstr(err.text, table[i].message))
            fail_msg("%s\n%s\nexpected: %s", table[i].filter, err.text, table[i].message);
    }
    assert_int_equal(rmap_alloc_live(), 0);
}

/* Each exclusive or writes both of its sides twice. */
static void translations_are_bounded(void **state)
{
    (void)state;
    struct test_scene t;
    struct rmap_error err = {0};
    char *text = NULL, filter[2000] = "H1";
    test_scene_init(&t);
    for (int i = 0; i < 400; i++)
        strncat(filter, "^H2", sizeof filter - strlen(filter) - 1);
    assert_int_equal(rmap_zemax_translate(filter, &t.scene, &text, &err), RMAP_INPUT);
    assert_non_null(strstr(err.text, "the filter's translation is too long"));
    memset(filter, '(', 1500);
    assert_int_equal(rmap_zemax_translate(filter, &t.scene, &text, &err), RMAP_INPUT);
    assert_non_null(strstr(err.text, "nested parentheses"));
    assert_int_equal(rmap_alloc_live(), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(flags_become_tests),
        cmocka_unit_test(wavelengths_are_the_scene_s),
        cmocka_unit_test(what_cannot_be_said_is_named),
        cmocka_unit_test(translations_are_bounded),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
