/* SPDX-License-Identifier: MIT
 *
 * Fields from shared objects: the example, one that misbehaves, and what is none.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "base/alloc.h"
#include "gradient/field_plugin.h"
#include "tests/unit/near.h"

static const double parameter[] = {1.6, 0.3, 20}, nm[] = {400, 500, 600};
static const struct raymap_field_setup setup = {3, parameter, 3, nm, 10};

static enum rmap_status load(const char *name, const struct raymap_field_setup *with,
                             struct rmap_field **field, struct rmap_error *err)
{
    char path[1024];
    (void)snprintf(path, sizeof path, "%s/%s", RAYMAP_PLUGIN_DIR, name);
    return rmap_field_plugin(field, path, with, err);
}

static void test_the_example(void **state)
{
    (void)state;
    struct rmap_field *field = NULL;
    double n;
    struct rmap_vec3 slope;
    assert_int_equal(load("rod.so", &setup, &field, NULL), RMAP_OK);
    assert_int_equal(field->n_channel, 1);
    /* alpha(20)^2 = 0.09 / 2 */
    assert_true(rmap_field_at(field, 2, rmap_vec3(1, 0, 20), &n, &slope));
    assert_near(n, 1.6 * sqrt(1 - 0.045), 1e-15);
    assert_near(n * slope.x, -1.6 * 1.6 * 0.045, 1e-15);
    assert_near(n * slope.z, 0.5 * 1.6 * 1.6 * 0.045 / 40, 1e-15);
    assert_false(rmap_field_at(field, 0, rmap_vec3(9, 0, 0), &n, &slope));
    rmap_field_destroy(field);
    assert_int_equal(rmap_alloc_live(), 0);
}

static void test_differences(void **state)
{
    (void)state;
    struct rmap_field *field = NULL;
    double n;
    struct rmap_vec3 slope;
    assert_int_equal(load("plain.so", &setup, &field, NULL), RMAP_OK);
    assert_int_equal(field->n_channel, 3);
    assert_true(rmap_field_at(field, 2, rmap_vec3(3, 0, 0), &n, &slope));
    assert_near(n, 1.73, 1e-15);
    assert_near(slope.x, 0.01, 1e-10);
    assert_near(slope.y, 0, 1e-10);
    rmap_field_destroy(field);
}

static void test_rubbish_is_no_index(void **state)
{
    (void)state;
    struct rmap_field *field = NULL;
    double n;
    struct rmap_vec3 slope;
    assert_int_equal(load("rubbish.so", &setup, &field, NULL), RMAP_OK);
    assert_true(rmap_field_at(field, 0, rmap_vec3(-1, -1, -1), &n, &slope));
    assert_false(rmap_field_at(field, 0, rmap_vec3(1, -1, -1), &n, &slope));
    assert_false(rmap_field_at(field, 0, rmap_vec3(-1, 1, -1), &n, &slope));
    assert_false(rmap_field_at(field, 0, rmap_vec3(-1, -1, 1), &n, &slope));
    rmap_field_destroy(field);
}

static void test_what_is_none(void **state)
{
    (void)state;
    const struct raymap_field_setup too_few = {1, parameter, 3, nm, 10};
    const struct {
        const char *name;
        const struct raymap_field_setup *with;
        const char *told;
    } mistake[] = {
        {"absent.so", &setup, "cannot be loaded"},
        {"newer.so", &setup, "is of version 2 of the interface"},
        {"rod.so", &too_few, "refuses its parameters: give [n0, alpha0, length]"},
    };
    for (size_t i = 0; i < sizeof mistake / sizeof mistake[0]; i++) {
        struct rmap_field *field = NULL;
        struct rmap_error err = {0};
        assert_int_equal(load(mistake[i].name, mistake[i].with, &field, &err), RMAP_INPUT);
        if (!strstr(err.text, mistake[i].told))
            fail_msg("%s: %s", mistake[i].name, err.text);
        assert_int_equal(rmap_alloc_live(), 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_example),
        cmocka_unit_test(test_differences),
        cmocka_unit_test(test_rubbish_is_no_index),
        cmocka_unit_test(test_what_is_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
