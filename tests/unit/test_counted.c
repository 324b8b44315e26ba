/* SPDX-License-Identifier: MIT
 *
 * Numbers and nouns as people write them.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "base/grouped.h"

static void test_numbers(void **state)
{
    char buffer[RMAP_GROUPED_LEN];
    (void)state;
    assert_string_equal(rmap_grouped(0, buffer), "0");
    assert_string_equal(rmap_grouped(999, buffer), "999");
    assert_string_equal(rmap_grouped(1000, buffer), "1,000");
    assert_string_equal(rmap_grouped(UINT64_MAX, buffer), "18,446,744,073,709,551,615");
}

static void test_nouns(void **state)
{
    (void)state;
    assert_string_equal(rmap_counted(0, "ray").text, "0 rays");
    assert_string_equal(rmap_counted(1, "ray").text, "1 ray");
    assert_string_equal(rmap_counted(1234, "ray").text, "1,234 rays");
    assert_string_equal(rmap_counted(2, "path").text, "2 paths");
    assert_string_equal(rmap_counted(1, "geometry").text, "1 geometry");
    assert_string_equal(rmap_counted(3, "geometry").text, "3 geometries");
    assert_string_equal(rmap_counted(3, "class").text, "3 classes");
    assert_string_equal(rmap_counted(3, "mesh").text, "3 meshes");
    assert_string_equal(rmap_counted(UINT64_MAX, "unfinished piece").text,
                        "18,446,744,073,709,551,615 unfinished pieces");
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_numbers),
                                       cmocka_unit_test(test_nouns)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
