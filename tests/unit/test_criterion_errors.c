/* SPDX-License-Identifier: MIT
 *
 * What a wrong criterion is told: exact texts, columns and carets.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "analysis/criterion/criterion.h"
#include "analysis/criterion/criterion_lex.h"
#include "base/alloc.h"
#include "base/rng.h"
#include "tests/criterion_scene.h"

#define FACTORS                                                                                    \
    "a factor stands before a number that sums may have, with blanks around the *: 2 * "           \
    "path_length"
#define VALUE_FIRST                                                                                \
    "what is compared stands first, a factor before it, with blanks around the *: hit(lens) > 2, " \
    "2 * x(NAME) > 3"

/* The message of a one-line criterion: place, text, then the line and the caret under columns
 * [column, column + width). */
static const struct {
    const char *text;
    int column, width;
    const char *message;
} case_table[] = {
    {"hit(*) and hit(lense.1)", 16, 7,
     "no object named 'lense.1' in this map (did you mean 'lens.1'?)"},
    {"hit(LENS.1)", 5, 6, "no object named 'LENS.1' in this map (did you mean 'lens.1'?)"},
    {"hit(qqqqqq)", 5, 6, "no object named 'qqqqqq' in this map"},
    {"hit(z*)", 5, 2, "no object in this map matches 'z*'"},
    {"hit('odd n\xc3\xa4m')", 5, 9,
     "no object named 'odd n\xc3\xa4m' in this map (did you mean 'odd n\xc3\xa4me'?)"},
    {"hit('odd n\xc3\xa4me') and hit(tub)", 25, 3,
     "no object named 'tub' in this map (did you mean 'tube'?)"},
    {"hit(n\xc3\xa4mlich\xe2\x89\xa5) or !", 5, 8,
     "no object named 'n\xc3\xa4mlich\xe2\x89\xa5' in this map"},
    {"hit(sensor)", 5, 6,
     "'sensor' is a detector, not an object (use registered(sensor) or crossed(sensor))"},
    {"hit(lamp)", 5, 4, "'lamp' is a source, not an object (use source(lamp))"},
    {"hit(black)", 5, 5, "'black' is a surface property, not an object (use surface(black))"},
    {"registered(tube)", 12, 4, "'tube' is an object, not a detector (use hit(tube))"},
    {"crossed('lens')", 9, 6, "'lens' is a group of objects, not a detector (use hit('lens'))"},
    {"source(sensr)", 8, 5, "no source named 'sensr' in this map"},
    {"source(lmap)", 8, 4, "no source named 'lmap' in this map (did you mean 'lamp'?)"},
    {"medium(tube)", 8, 4, "'tube' is an object, not a medium (use hit(tube))"},
    {"surface(blck)", 9, 4, "no surface named 'blck' in this map (did you mean 'black'?)"},
    {"ended(absorbed, lamp)", 17, 4,
     "'lamp' is a source, not an object or medium (use source(lamp))"},
    {"tube", 1, 4, "'tube' is an object, not a test (use hit(tube))"},
    {"'odd n\xc3\xa4me' or all", 1, 10,
     "'odd n\xc3\xa4me' is an object, not a test (use hit('odd n\xc3\xa4me'))"},
    {"hitt(tube)", 1, 4, "unknown test 'hitt' (did you mean 'hit'?)"},
    {"scatter(harvy)", 9, 5, "unknown scatter model 'harvy' (did you mean 'harvey'?)"},
    {"xyzzy(tube)", 1, 5,
     "unknown test 'xyzzy': say one of all source hit surface scatter event medium after at "
     "registered "
     "crossed detected ended path segments bounces ghost_order scatter_order wavelength "
     "photon_energy flux path_length "
     "optical_path group_path start_x start_y start_z ray angle x y world_x world_y world_z time"},
    {"hit(tube, reflect_speculr)", 11, 15,
     "unknown event 'reflect_speculr' (did you mean 'reflect_specular'?)"},
    {"hit(tube, refl)", 11, 4, "unknown event 'refl' (did you mean 'reflect'?)"},
    {"event(reflect, tube)", 14, 1, "expected ')', found ','"},
    {"medium(n-bk7)", 9, 1,
     "unexpected character '-' (a name with such signs stands in single quotes)"},
    {"all - all", 5, 1, "unexpected character '-'"},
    {"hit(tube) + 1 > 2", 11, 1, "unexpected character '+'"},
    {"path_length == optical_path", 13, 2,
     "expected <, <=, > or >= (numbers are compared with each other by these), found '=='"},
    {"path_length > wavelength", 15, 10, "this number is in another unit than those before it"},
    {"path_length - 1 mm > 2 * segments", 26, 8,
     "this number is in another unit than those before it"},
    {"path_length < optical_path < path_length", 28, 1, "a comparison has two sides"},
    {"hit(tube where x > angle)", 20, 5, "this number is in another unit than those before it"},
    {"hit(tube where x - y == 3)", 22, 2,
     "expected <, <=, > or >= (numbers are compared with each other by these), found '=='"},
    {"hit(tube where 3 < x)", 16, 1,
     "expected a number of a step such as angle, x or length, found '3'"},
    {"path_length > 2 * path_length(air)", 19, 11,
     "path_length(NAME) is compared with values alone, not in sums"},
    {"path_length(air) - 1 > 3", 1, 11,
     "path_length(NAME) is compared with values alone, not in sums"},
    {"segments > 2 * bounces", 16, 7, "bounces is compared with values alone, not in sums"},
    {"2 * event > 3", 5, 5, "event is compared with values alone, not in sums"},
    {"bounces > 2 * segments", 13, 1, FACTORS},
    {"path_length > 2*optical_path", 16, 13, FACTORS},
    {"path_length*2 > 3", 1, 13, FACTORS},
    {"x(sensor)*2 > 3", 10, 2, FACTORS},
    {"registered(sensor where x*2 > 3)", 25, 3, FACTORS},
    {"3 mm > x(sensor)", 1, 1, VALUE_FIRST},
    {"2*x(sensor) > 3", 1, 1, VALUE_FIRST},
    {"hit(tube where length * 2 > x)", 23, 1, "the factor stands before: '2 * length'"},
    {"path_length - > 1", 15, 1, "expected a number such as x(NAME) or path_length, found '>'"},
    {"path_length < 2 * 3", 19, 1, "expected a number such as x(NAME) or path_length, found '3'"},
    {"2 * hit(tube) > path_length", 5, 3,
     "expected a number such as x(NAME) or path_length, found 'hit'"},
    {"surface(reflectance)", 9, 11,
     "'reflectance' is a number: compare it, as in 'surface(reflectance < 0.1)'"},
    {"hit(tube, absorb, reflect)", 19, 7, "only one event can be given"},
    {"hit(tube, face 3)", 16, 1, "there is no face 3: face 0 to 2 exist here"},
    {"hit(tube, triangle 8..9)", 20, 1, "there is no triangle 8: triangle 0 to 7 exist here"},
    {"hit(lens.1, face 1)", 18, 1, "there is no face 1: face 0 to 0 exist here"},
    {"hit(tube, triangle 7..2)", 20, 1, "this range runs backwards"},
    {"hit(tube, face -1)", 16, 2, "expected a whole number from 0"},
    {"hit(tube, face 1.5)", 16, 3, "expected a whole number from 0"},
    {"hit(tube, face 1, triangle 2)", 19, 8, "only one range of faces or triangles can be given"},
    {"hit()", 5, 1, "expected the name of an object, found ')'"},
    {"hit(tube, side left)", 16, 4, "expected front or back, found 'left'"},
    {"hit(tube, side front, side back)", 23, 4, "only one side can be given"},
    {"at(tube)", 1, 2, "'at' is of a registration: registered(NAME where at(OBJECT))"},
    {"registered(sensor where at(absorb))", 25, 2,
     "'at' is of detectors that lie on an object ('on' in the scene); free in space there is no "
     "step at the detector's place"},
    {"registered(screen where at(face 3))", 33, 1, "there is no face 3: face 0 to 2 exist here"},
    {"registered(screen where at())", 28, 1, "expected the name of an object, found ')'"},
    {"registered(screen where path(\"(T|R\"))", 31, 1, "this parenthesis is never closed"},
    {"hit(3lens)", 5, 1,
     "expected the name of an object (one that begins with a digit stands in single quotes), found "
     "'3'"},
    {"hit(\"tube\")", 5, 6, "expected the name of an object, found '\"tube\"'"},
    {"hit(and)", 5, 3, "expected the name of an object, found 'and'"},
    {"hit tube", 5, 4, "expected '(', found 'tube'"},
    {"hit(tube", 9, 1, "expected ',' or ')', found the end"},
    {"hit(tube lens)", 10, 4, "expected ',' or ')', found 'lens'"},
    {"surface(reflectence < 0.1)", 9, 11,
     "unknown surface parameter 'reflectence' (did you mean 'reflectance'?)"},
    {"event(absorption)", 7, 10,
     "unknown event 'absorption': say one of reflect_specular reflect_diffuse transmit_specular "
     "transmit_diffuse total_reflection absorb scatter_volume fluoresce gradient element left "
     "limit error reflect transmit specular diffuse scatter"},
    {"ended(absorbd)", 7, 7, "unknown ending 'absorbd' (did you mean 'absorbed'?)"},
    {"ended(3)", 7, 1, "expected absorbed, left, limit or error, found '3'"},
    {"wavelength", 1, 10,
     "'wavelength' is a number: compare it, as in 'wavelength > 10' or 'wavelength in 1..10'"},
    {"angle(sensor)", 1, 5, "'angle' is a number: compare it, as in 'angle(sensor) > 10'"},
    {"angle < 10", 7, 1, "expected '(', found '<'"},
    {"segments > ", 12, 1, "expected a number, found the end"},
    {"segments > tube", 12, 4, "expected a number, found 'tube'"},
    {"segments in 4..2", 13, 1, "this range runs backwards"},
    {"segments in 4", 14, 1, "expected '..' and the end of the range, found the end"},
    {"segments > 2 mm", 14, 2, "'mm' is no unit here (none: this is a plain number)"},
    {"path_length > 2 mW", 17, 2, "'mW' is no unit here (pm nm um mm cm m km in)"},
    {"flux > 2 lm", 10, 2, "'lm' is no unit here (W uW mW kW)"},
    {"x(*) < 2 mm", 10, 2, "'mm' is no unit here (none: the detectors differ in theirs)"},
    {"x(far) < 2 mm", 12, 2, "'mm' is no unit here (deg rad mrad)"},
    {"time(sensor) < 2 minutes", 18, 7, "'minutes' is no unit here (s ms us ns ps fs)"},
    {"hit(tube) = 2", 11, 1, "unexpected '=' (equality is written '==')"},
    {"2 < hit(tube)", 1, 1, VALUE_FIRST},
    {"(hit(tube) or all) >= 2", 20, 2, "only a single test can be counted, not an expression"},
    {"hit(tube) hit(lens)", 11, 3, "expected 'and', 'or' or the end, found 'hit'"},
    {"hit(tube) >= 2 hit(lens)", 16, 3, "expected 'and', 'or' or the end, found 'hit'"},
    {"all)", 4, 1, "expected 'and', 'or' or the end, found ')'"},
    {"(all", 1, 1, "this parenthesis is never closed"},
    {"((all) all)", 8, 3, "expected 'and', 'or' or ')', found 'all'"},
    {"()", 2, 1, "expected a test such as hit(name) or all, found ')'"},
    {"all and", 8, 1, "expected a test such as hit(name) or all, found the end"},
    {"not", 4, 1, "expected a test such as hit(name) or all, found the end"},
    {"and all", 1, 3, "expected a test such as hit(name) or all, found 'and'"},
    {"", 1, 1, "the criterion is empty (all rays: write 'all')"},
    {"   ", 4, 1, "the criterion is empty (all rays: write 'all')"},
    {"hit('tube)", 5, 1, "this quote is never closed"},
    {"all $ yes", 5, 1, "unexpected character '$'"},
    {"registered(sensor, circle(1))", 20, 6,
     "expected rect, ellipse, polygon, cells or where, found 'circle'"},
    {"registered(sensor, rect(1, 2, 3))", 20, 4, "rect wants four numbers x0, y0, x1, y1, not 3"},
    {"registered(sensor, ellipse(1, 2, 3, 0))", 20, 7, "the half-axes of an ellipse must be > 0"},
    {"registered(sensor, ellipse(1, 2, 3))", 20, 7,
     "ellipse wants four numbers cx, cy, rx, ry (and an angle), not 3"},
    {"registered(sensor, ellipse(0.5, 0.5, 0.1, 0.2, 30, rel))", 20, 7,
     "an ellipse in relative coordinates cannot be turned: leave out the angle, or 'rel'"},
    {"registered(sensor, ellipse(1, 2, 3, 4, 5 mm))", 42, 2, "'mm' is no unit here (deg rad mrad)"},
    {"registered(sensor, polygon(0,0, 1,1))", 20, 7,
     "polygon wants pairs x, y for three corners or more"},
    {"registered(sensor, polygon(0,0, 1,1, 2,2, 3))", 20, 7,
     "polygon wants pairs x, y for three corners or more"},
    {"registered(sensor, rect(0, 0, 1 mm, 1, rel))", 20, 4, "relative coordinates have no unit"},
    {"registered(far, rect(0, 0, 1, 1, world))", 34, 5,
     "'world' is for one plane whose x and y lie along axes of the world; say where world_x in "
     "0..1 and world_y in 0..1"},
    {"registered(sensor, cells(1..2))", 30, 1,
     "expected ',' and the second range of cells, found ')'"},
    {"registered(sensor, rect(0,0,1,1), rect(0,0,1,1))", 35, 4, "only one region can be given"},
    {"registered(sensor where angel < 10)", 25, 5,
     "unknown number of a registration 'angel' (did you mean 'angle'?)"},
    {"registered(sensor where hot(tube))", 25, 3,
     "unknown number of a registration 'hot' (did you mean 'hit'?)"},
    {"registered(sensor where hit(tub))", 29, 3,
     "no object named 'tub' in this map (did you mean 'tube'?)"},
    {"registered(sensor where ghost_order)", 25, 11,
     "'ghost_order' is a number: compare it, as in 'ghost_order > 10' or 'ghost_order in 1..10'"},
    {"after(tube)", 1, 5, "'after' is of a registration: registered(NAME where after(OBJECT))"},
    {"ghost_order(sensor) > 2", 1, 11,
     "'ghost_order' takes no name here; at a registration it is asked for as registered(NAME where "
     "ghost_order >= 1)"},
    {"registered(sensor where x)", 25, 1, "'x' is a number: compare it, as in 'x > 10'"},
    {"registered(sensor where x > 0 y < 0)", 31, 1, "'y' is no unit here (pm nm um mm cm m km in)"},
    {"registered(sensor where)", 24, 1,
     "expected angle, x, y, time, optical_path, or a test of the steps before such as hit(NAME), "
     "found ')'"},
    {"registered(sensor where (x > 0)", 32, 1, "expected 'and', 'or' or ')', found the end"},
    {"all and @ghost", 10, 5,
     "no criterion is named 'ghost': --criteria FILE defines names, as let ghost = ..., and raymap "
     "select keeps rays in the map by name"},
    {"let ghost = all", 1, 3, "'let' defines names in a file that --criteria names"},
};

static void compile_wrong(const char *text, struct rmap_error *err)
{
    struct test_scene t;
    struct rmap_criterion *criterion = NULL;
    test_scene_init(&t);
    *err = (struct rmap_error){0};
    if (rmap_criterion_compile(text, &t.scene, &criterion, err) != RMAP_INPUT)
        fail_msg("accepted: %s", text);
    assert_null(criterion);
    assert_int_equal(err->status, RMAP_INPUT);
}

static void test_messages(void **state)
{
    (void)state;
    int n_wrong = 0;
    for (size_t i = 0; i < sizeof case_table / sizeof *case_table; i++) {
        struct rmap_error err;
        char expected[1024], tail[64] = {0};
        memset(tail, '~', (size_t)case_table[i].width - 1);
        snprintf(expected, sizeof expected, "criterion:1:%d: error: %s\n  %s\n  %*s^%s",
                 case_table[i].column, case_table[i].message, case_table[i].text,
                 case_table[i].column - 1, "", tail);
        compile_wrong(case_table[i].text, &err);
        if (strcmp(err.text, expected) != 0) {
            print_error("got:\n%s\nexpected:\n%s\n", err.text, expected);
            n_wrong++;
        }
    }
    assert_int_equal(n_wrong, 0);
    assert_int_equal(rmap_alloc_live(), 0);
}

static void test_lines(void **state)
{
    (void)state;
    struct rmap_error err;
    compile_wrong("all and\n\t hit(foo) or\n all", &err);
    assert_string_equal(err.text, "criterion:2:7: error: no object named 'foo' in this map\n"
                                  "  \t hit(foo) or\n  \t     ^~~");
    compile_wrong("all and\r\n hit(foo)\r\n", &err);
    assert_string_equal(err.text, "criterion:2:6: error: no object named 'foo' in this map\n"
                                  "   hit(foo)\n       ^~~");
    compile_wrong("all or\n", &err);
    assert_string_equal(err.text,
                        "criterion:2:1: error: expected a test such as hit(name) or all, found the "
                        "end\n  \n  ^");
}

/* A place far along a long line is shown with what stands about it. */
static void test_long_line(void **state)
{
    (void)state;
    enum { N = 200000 };
    char *text = rmap_alloc(5 * N + 64, 1);
    struct rmap_error err;
    for (size_t i = 0; i < N; i++)
        memcpy(text + 5 * i, "all &", 5);
    memcpy(text + 5 * N, "hit(foo) and all", 17);
    compile_wrong(text, &err);
    const char *place = strstr(err.text, "criterion:1:1000005: error: no object named 'foo'");
    assert_ptr_equal(place, err.text);
    const char *line = strchr(err.text, '\n') + 1, *caret = strchr(line, '\n') + 1;
    assert_true(caret - line < 120);
    assert_memory_equal(line + (strchr(caret, '^') - caret), "foo", 3);
    rmap_free(text);
}

static void test_long_name(void **state)
{
    (void)state;
    char text[600] = "hit(";
    struct rmap_error err;
    for (size_t i = 4; i < 504; i += 2)
        memcpy(text + i, "\xc3\xa4", 2);
    text[504] = ')';
    compile_wrong(text, &err);
    assert_non_null(strstr(err.text, "...' in this map"));
    assert_int_equal(rmap_criterion_check_utf8(err.text, NULL), RMAP_OK);
    memset(text, 'a', sizeof text - 1);
    compile_wrong(text, &err);
    assert_non_null(strstr(err.text, "criterion:1:1: error: a word of 599 bytes is too long"));
}

/* Arbitrary bytes, a megabyte of them too: always an error with its place. */
static void test_binary(void **state)
{
    (void)state;
    enum { LONGEST = 1 << 20 };
    char *text = rmap_alloc(LONGEST + 1, 1);
    double u[4];
    struct rmap_error err;
    for (uint64_t round = 0; round < 300; round++) {
        size_t n = round < 299 ? 1 + (size_t)(round % 64) : LONGEST;
        for (size_t i = 0; i < n; i++) {
            if (i % 4 == 0)
                rmap_rng(7, round, (uint32_t)(i / 4), 0, u);
            text[i] = (char)(1 + (int)(u[i % 4] * 255.0));
        }
        text[0] = '$';
        text[n] = 0;
        compile_wrong(text, &err);
        assert_memory_equal(err.text, "criterion:", 10);
        assert_true(strlen(err.text) < RMAP_ERROR_TEXT_LEN);
    }
    rmap_free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_messages),  cmocka_unit_test(test_lines),
        cmocka_unit_test(test_long_line), cmocka_unit_test(test_long_name),
        cmocka_unit_test(test_binary),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
