/* SPDX-License-Identifier: MIT
 *
 * Named criteria: what a file of definitions may say, and what it is told when it is wrong.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "analysis/criterion/criterion.h"
#include "analysis/criterion/criterion_file.h"
#include "base/alloc.h"
#include "tests/criterion_scene.h"

enum { N_RAY = 4 };

struct fixture {
    struct test_scene scene;
    struct rmap_portion *portion;
};

/* Rays 0 to 3: hit lens.1; hit lens.1 and tube; hit tube; hit nothing. */
static int setup(void **state)
{
    static const int32_t object[N_RAY][2] = {{0, -1}, {0, 1}, {1, -1}, {-1, -1}};
    struct fixture *t = rmap_alloc(1, sizeof *t);
    test_scene_init(&t->scene);
    assert_int_equal(rmap_portion_create(N_RAY, 3, &t->portion, NULL), RMAP_OK);
    for (int ray = 0; ray < N_RAY; ray++) {
        assert_true(test_add_ray(t->portion, &(struct test_ray){.id = (uint64_t)ray}));
        for (int i = 0; i < 2; i++)
            assert_true(test_add_step(
                t->portion,
                &(struct test_step){.object = object[ray][i],
                                    .event = object[ray][i] < 0 ? RMAP_EVENT_LEFT
                                                                : RMAP_EVENT_REFLECT_SPECULAR}));
    }
    *state = t;
    return 0;
}

static int teardown(void **state)
{
    struct fixture *t = *state;
    rmap_portion_destroy(t->portion);
    rmap_free(t);
    assert_int_equal(rmap_alloc_live(), 0);
    return 0;
}

static enum rmap_status answer(const struct fixture *t, const char *file, const char *text,
                               unsigned *rays, struct rmap_error *err)
{
    const double flux[2] = {1.0, 1.0};
    uint8_t match[N_RAY];
    struct rmap_criteria *criteria = NULL;
    struct rmap_criterion *criterion = NULL;
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(rmap_criteria_create(file, "some.txt", &criteria, err));
    RMAP_TRY(rmap_criterion_compile_with(text, criteria, &t->scene.scene, &criterion, err));
    RMAP_TRY(rmap_criterion_evaluate(criterion, t->portion, flux, match, err));
    *rays = 0;
    for (int i = 0; i < N_RAY; i++)
        *rays |= (unsigned)match[i] << i;
out:
    rmap_criterion_destroy(criterion);
    rmap_criteria_destroy(criteria);
    return st;
}

static void names_stand_for_their_criteria(void **state)
{
    static const struct {
        const char *file, *text;
        unsigned rays;
    } table[] = {
        {"let a = hit(tube)", "@a", 6},
        {"let a = hit(tube)\nlet b = hit(lens.1)\n", "@a and @b", 2},
        {"let a = hit(tube) let b = hit(lens.1)", "@a or @b", 7},
        {"let a = hit(tube) or hit(lens.1)", "not @a", 8}, /* as if in parentheses */
        {"let a = hit(tube) or hit(lens.1)", "@a and hit(lens.1)", 3},
        {"let a = @b and hit(tube)\nlet b = hit(lens.1)", "@a", 2},   /* any order */
        {"let a = hit(*, reflect) >= 2\nlet b = hit(tube)", "@a", 2}, /* `let` is no unit */
        {"let a = flux < 3\nlet b = all", "@b", 15},
        {"let 'odd one' = hit(tube)", "@'odd one'", 6},
        {"# a comment 'with a quote\nlet a = hit(tube) # and another\n  and hit(lens.1)", "@a", 2},
        {"let a = hit('lens.1') # 'x\nlet b = all", "@a", 3},
        {"let a = path(\".*R@tube.*\")", "@a and not @a", 0},
        {"let hit = all", "@hit and hit(tube)", 6}, /* words of the language are names too */
        {"let let = hit(tube)", "@let", 6},
        {"\r\nlet a =\r\n hit(tube)\r\n", "(@a)", 6},
        {"\xef\xbb\xbflet a = hit(tube)", "@a", 6}, /* a byte order mark */
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        struct rmap_error err = {0};
        unsigned rays = 0;
        if (answer(*state, table[i].file, table[i].text, &rays, &err) != RMAP_OK)
            fail_msg("%s\n%s\n%s", table[i].file, table[i].text, err.text);
        if (rays != table[i].rays)
            fail_msg("%s\n%s: rays %x, expected %x", table[i].file, table[i].text, rays,
                     table[i].rays);
    }
}

static void mistakes_name_their_place(void **state)
{
    static const struct {
        const char *file, *text, *message;
    } table[] = {
        {"hit(tube)", "@a",
         "some.txt:1:1: error: expected 'let NAME = CRITERION'\n  hit(tube)\n  ^~~"},
        {"", "@a", "some.txt:1:1: error: expected 'let NAME"},
        {"let", "@a", "some.txt:1:4: error: expected a name behind 'let'"},
        {"let a hit(tube)", "@a", "some.txt:1:7: error: expected '='"},
        {"let a == all", "@a", "some.txt:1:7: error: expected '='"},
        {"let a =", "@a", "some.txt:1:5: error: no criterion stands behind this name"},
        {"let a = let b = all", "@a", "some.txt:1:5: error: no criterion stands behind this"},
        {"let a = all\nlet a = all", "@a", "some.txt:2:5: error: 'a' is defined already"},
        {"let a* = all", "@a", "some.txt:1:5: error: a name for a criterion has no wildcards"},
        {"let a = all\nlet b = hit(tubb)", "@b",
         "some.txt:2:13: error: no object named 'tubb' in this map (did you mean 'tube'?)\n"
         "  let b = hit(tubb)\n              ^~~~"},
        {"let a = all\nlet b = hit(tube", "@b", "some.txt:2:17: error: expected ',' or ')'"},
        {"let a = all all", "@a", "some.txt:1:13: error: expected 'and', 'or' or the end"},
        {"let a = all", "@b", "criterion:1:2: error: no criterion is named 'b' in some.txt"},
        {"let ghost = all", "all and @gost",
         "criterion:1:10: error: no criterion is named 'gost' in "
         "some.txt (did you mean 'ghost'?)"},
        {"let a = @a", "@a", "some.txt:1:10: error: 'a' is defined by itself"},
        {"let a = @b\nlet b = not @a", "@a", "some.txt:2:14: error: 'a' is defined by itself"},
        {"let a = all", "@a >= 2", "criterion:1:4: error: only a single test can be counted"},
        {"let a = all", "@", "criterion:1:2: error: expected the name of a criterion"},
        {"let a = angle < 3", "registered(sensor where @a)",
         "criterion:1:25: error: names cannot stand inside 'where'"},
        {"let a = \"\nlet b = all", "@b", "some.txt:1:9: error: this quote is never closed"},
        {"let a = \xff", "@a", "some.txt:1:9: error: this is not UTF-8 text"},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        struct rmap_error err = {0};
        unsigned rays = 0;
        assert_int_equal(answer(*state, table[i].file, table[i].text, &rays, &err), RMAP_INPUT);
        if (!strstr(err.text, table[i].message))
            fail_msg("%s\n%s\n%s\nexpected: %s", table[i].file, table[i].text, err.text,
                     table[i].message);
    }
}

/* Only what is used must fit the map: a file may serve several. */
static void unused_names_are_not_resolved(void **state)
{
    struct rmap_error err = {0};
    unsigned rays = 0;
    assert_int_equal(answer(*state, "let a = hit(elsewhere)\nlet b = hit(tube)", "@b", &rays, &err),
                     RMAP_OK);
    assert_int_equal(rays, 6);
}

static void definitions_that_multiply_are_bounded(void **state)
{
    char file[4096] = "let a0 = all\n";
    for (int i = 1; i < 60; i++) {
        size_t len = strlen(file);
        (void)snprintf(file + len, sizeof file - len, "let a%d = @a%d and @a%d\n", i, i - 1, i - 1);
    }
    struct rmap_error err = {0};
    unsigned rays = 0;
    assert_int_equal(answer(*state, file, "@a10", &rays, &err), RMAP_OK);
    assert_int_equal(rays, 15);
    assert_int_equal(answer(*state, file, "@a59", &rays, &err), RMAP_INPUT);
    assert_non_null(strstr(err.text, "has more than 100000 tests"));
}

static void a_file_lists_its_names(void **state)
{
    (void)state;
    struct rmap_criteria *criteria = NULL;
    struct rmap_error err = {0};
    assert_int_equal(
        rmap_criteria_create("let a = all # x\n\nlet 'b c' = not  all\n", "f", &criteria, &err),
        RMAP_OK);
    assert_int_equal(rmap_criteria_count(criteria), 2);
    assert_string_equal(rmap_criteria_name(criteria, 1), "b c");
    assert_string_equal(rmap_criteria_reference(criteria, 0), "@a");
    assert_string_equal(rmap_criteria_reference(criteria, 1), "@'b c'");
    assert_string_equal(rmap_criteria_definition(criteria, 0), "all");
    assert_string_equal(rmap_criteria_definition(criteria, 1), "not  all");
    rmap_criteria_destroy(criteria);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(names_stand_for_their_criteria, setup, teardown),
        cmocka_unit_test_setup_teardown(mistakes_name_their_place, setup, teardown),
        cmocka_unit_test_setup_teardown(unused_names_are_not_resolved, setup, teardown),
        cmocka_unit_test_setup_teardown(definitions_that_multiply_are_bounded, setup, teardown),
        cmocka_unit_test_setup_teardown(a_file_lists_its_names, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
