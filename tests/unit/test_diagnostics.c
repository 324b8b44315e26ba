/* SPDX-License-Identifier: MIT */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "tests/unit/read_text.h"

#define ERROR RMAP_SEVERITY_ERROR

static void test_print_sorts_by_place(void **state)
{
    (void)state;
    struct rmap_diagnostics d;
    rmap_diagnostics_init(&d, "a.yaml");
    rmap_diagnostics_add(&d, ERROR, 7, 3, "later %d", 7);
    rmap_diagnostics_add(&d, RMAP_SEVERITY_WARNING, 2, 9, "right");
    rmap_diagnostics_add(&d, ERROR, 2, 1, "left");
    rmap_diagnostics_add(&d, ERROR, 0, 0, "whole\033[1m");
    char *text = printed(&d);
    assert_string_equal(text, "a.yaml: error: whole?[1m\n"
                              "a.yaml:2:1: error: left\n"
                              "a.yaml:2:9: warning: right\n"
                              "a.yaml:7:3: error: later 7\n");
    assert_int_equal(d.n_error, 3);
    free(text);
    rmap_diagnostics_fini(&d);
    assert_int_equal(rmap_alloc_live(), 0);
}

static void test_many_are_counted_but_not_kept(void **state)
{
    (void)state;
    struct rmap_diagnostics d;
    rmap_diagnostics_init(&d, "a");
    for (int i = 0; i < RMAP_DIAGNOSTICS_MAX + 5; i++) {
        assert_int_equal(rmap_diagnostics_full(&d), i >= RMAP_DIAGNOSTICS_MAX);
        rmap_diagnostics_add(&d, ERROR, 1, 1, "x");
    }
    assert_int_equal(d.n, RMAP_DIAGNOSTICS_MAX);
    assert_int_equal(d.n_error, RMAP_DIAGNOSTICS_MAX + 5);
    char *text = printed(&d);
    assert_non_null(strstr(text, "\na: and 5 more\n"));
    free(text);
    rmap_diagnostics_fini(&d);
}

static void test_short_memory_still_counts(void **state)
{
    (void)state;
    for (int fail_at = 1; fail_at < 6; fail_at++) {
        struct rmap_diagnostics d;
        rmap_alloc_fail_at(fail_at);
        rmap_diagnostics_init(&d, "a");
        rmap_diagnostics_add(&d, ERROR, 1, 1, "x");
        char *text = printed(&d);
        rmap_alloc_fail_at(0);
        assert_int_equal(d.n_error, 1);
        free(text);
        rmap_diagnostics_fini(&d);
        assert_int_equal(rmap_alloc_live(), 0);
    }
}

static void test_nearest_word(void **state)
{
    (void)state;
    static const char *const word[] = {"bk7", "air", NULL, "absorber", "fresnel"};
    assert_string_equal(rmap_nearest_word("bk77", word, 5), "bk7");
    assert_string_equal(rmap_nearest_word("AIR", word, 5), "air");
    assert_string_equal(rmap_nearest_word("absrober", word, 5), "absorber");
    assert_string_equal(rmap_nearest_word("fresnell", word, 5), "fresnel");
    assert_null(rmap_nearest_word("unrelated", word, 5));
    assert_null(rmap_nearest_word("", word, 0));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_print_sorts_by_place),
        cmocka_unit_test(test_many_are_counted_but_not_kept),
        cmocka_unit_test(test_short_memory_still_counts),
        cmocka_unit_test(test_nearest_word),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
