/* SPDX-License-Identifier: MIT
 *
 * Structure of criteria: precedence, equivalent spellings, columns, portions that may be skipped,
 * and texts at the edge of what is sensible.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "analysis/criterion/criterion.h"
#include "analysis/criterion/criterion_tree.h"
#include "base/alloc.h"
#include "tests/criterion_scene.h"

/* Eight rays that tell three independent facts: bit 0 source(sun), bit 1 ended(left), bit 2
 * segments == 2. */
static struct rmap_portion *make_truth_table(void)
{
    struct rmap_portion *portion = NULL;
    assert_int_equal(rmap_portion_create(8, 3, &portion, NULL), RMAP_OK);
    for (int i = 0; i < 8; i++) {
        struct test_ray ray = {.id = (uint64_t)i, .source = i & 1, .weight = 1.0};
        ray.stop = i & 2 ? RMAP_STOP_LEFT : RMAP_STOP_ABSORBED;
        assert_true(test_add_ray(portion, &ray));
        for (int s = 0; s < (i & 4 ? 2 : 1); s++)
            assert_true(test_add_step(portion, &(struct test_step){.object = -1}));
    }
    return portion;
}

static unsigned truth_of(const char *text)
{
    static const double flux_per_weight[] = {1.0, 1.0};
    struct test_scene t;
    struct rmap_criterion *criterion = NULL;
    struct rmap_error err = {0};
    uint8_t match[8];
    unsigned truth = 0;
    test_scene_init(&t);
    struct rmap_portion *portion = make_truth_table();
    if (rmap_criterion_compile(text, &t.scene, &criterion, &err) != RMAP_OK)
        fail_msg("%.900s", err.text);
    assert_string_equal(rmap_criterion_text(criterion), text);
    assert_int_equal(rmap_criterion_evaluate(criterion, portion, flux_per_weight, match, &err),
                     RMAP_OK);
    for (int i = 0; i < 8; i++)
        truth |= (unsigned)match[i] << i;
    rmap_criterion_destroy(criterion);
    rmap_portion_destroy(portion);
    return truth;
}

/* a, b, c of a text become the three facts. */
static unsigned truth_of_letters(const char *letters)
{
    static const char *const fact[] = {"source(sun)", "ended(left)", "segments == 2"};
    char text[512] = "";
    for (const char *c = letters; *c; c++) {
        char one[2] = {*c, 0};
        bool alone = (c == letters || !strchr("abcdefghijklmnopqrstuvwxyz", c[-1])) &&
                     !(c[1] >= 'a' && c[1] <= 'z');
        const char *more = alone && *c >= 'a' && *c <= 'c' ? fact[*c - 'a'] : one;
        strncat(text, more, sizeof text - strlen(text) - 1);
    }
    return truth_of(text);
}

enum { A = 0xaa, B = 0xcc, C = 0xf0 };

static void test_precedence(void **state)
{
    (void)state;
    static const struct {
        const char *letters;
        unsigned truth;
    } row[] = {
        {"a", A},
        {"not a", 0xff & ~A},
        {"a and b", A & B},
        {"a or b", A | B},
        {"a or b and c", A | (B & C)},
        {"a and b or c", (A & B) | C},
        {"(a or b) and c", (A | B) & C},
        {"not a and b", (0xff & ~A) & B},
        {"not a or b", (0xff & ~A) | B},
        {"not (a and b)", 0xff & ~(A & B)},
        {"not (a or b) and not c", 0xff & ~(A | B) & ~C},
        {"a and not b or not c and b", (A & (0xff & ~B)) | ((0xff & ~C) & B)},
        {"a | b & c", A | (B & C)},
        {"a || b && c", A | (B & C)},
        {"a|b&c", A | (B & C)},
        {"!a&b", (0xff & ~A) & B},
        {"!!a", A},
        {"not not not a", 0xff & ~A},
        {"not !(not (a))", 0xff & ~A},
        {"a or a or b or c and c", A | B | C},
        {"((a))", A},
        {"a\nand\n\tb", A & B},
    };
    for (size_t i = 0; i < sizeof row / sizeof *row; i++)
        if (truth_of_letters(row[i].letters) != row[i].truth)
            fail_msg("%s: %02x, expected %02x", row[i].letters, truth_of_letters(row[i].letters),
                     row[i].truth);
}

/* De Morgan and its like over every pair of facts. */
static void test_laws(void **state)
{
    (void)state;
    static const char *const law[][2] = {
        {"not (a and b)", "not a or not b"},
        {"not (a or c)", "not a and not c"},
        {"a and (b or c)", "a and b or a and c"},
        {"a or b and c", "(a or b) and (a or c)"},
        {"a and a", "a"},
        {"a or not a", "all"},
        {"a and not a", "not all"},
    };
    for (size_t i = 0; i < sizeof law / sizeof *law; i++)
        assert_int_equal(truth_of_letters(law[i][0]), truth_of_letters(law[i][1]));
}

static char *repeat(const char *before, const char *one, size_t n, const char *after)
{
    size_t len = strlen(one), head = strlen(before), tail = strlen(after);
    char *text = rmap_alloc(head + n * len + tail + 1, 1);
    assert_non_null(text);
    memcpy(text, before, head);
    for (size_t i = 0; i < n; i++)
        memcpy(text + head + i * len, one, len);
    memcpy(text + head + n * len, after, tail);
    return text;
}

static void test_many_terms(void **state)
{
    (void)state;
    char *text = repeat("ended(left)", " or source(sun)", 10000, "");
    assert_int_equal(truth_of(text), A | B);
    rmap_free(text);
    text = repeat("ended(left)", " and source(sun)", 10000, "");
    assert_int_equal(truth_of(text), A & B);
    rmap_free(text);
    text = repeat("", "not ", 100001, "source(sun)");
    assert_int_equal(truth_of(text), 0xff & ~A);
    rmap_free(text);
    text = repeat("all and", " ", 1 << 20, "source(sun)");
    assert_int_equal(truth_of(text), A);
    rmap_free(text);
    text = repeat("all", "|event(left)", 87381, ""); /* 1 MB */
    assert_int_equal(truth_of(text), 0xff);
    rmap_free(text);
}

static void test_nesting(void **state)
{
    (void)state;
    char *open = repeat("", "(", 1000, "source(sun)");
    char *text = repeat(open, ")", 1000, "");
    assert_int_equal(truth_of(text), A);
    rmap_free(text);
    rmap_free(open);
    open = repeat("", "ended(left) or not (", 1000, "source(sun)");
    text = repeat(open, ")", 1000, "");
    assert_int_equal(truth_of(text), A | B); /* an even number of nots */
    rmap_free(text);
    rmap_free(open);

    struct test_scene t;
    struct rmap_criterion *criterion = NULL;
    struct rmap_error err = {0};
    test_scene_init(&t);
    text = repeat("", "(", 100000, "all");
    assert_int_equal(rmap_criterion_compile(text, &t.scene, &criterion, &err), RMAP_INPUT);
    assert_non_null(strstr(err.text, "criterion:1:2001: error: more than 2000 nested parentheses"));
    rmap_free(text);
    text = repeat("registered(sensor where ", "(", 100000, "x > 0");
    assert_int_equal(rmap_criterion_compile(text, &t.scene, &criterion, &err), RMAP_INPUT);
    assert_non_null(strstr(err.text, "nested parentheses"));
    rmap_free(text);
}

static void test_columns(void **state)
{
    (void)state;
#define RAYS(field) RMAP_COLUMN_BIT(RMAP_RAY_##field)
#define STEP(field) RMAP_COLUMN_BIT(RMAP_SEGMENT_##field)
#define SEEN(field) RMAP_COLUMN_BIT(RMAP_REGISTRATION_##field)
    static const struct {
        const char *text;
        rmap_column_set columns;
    } row[] = {
        {"all", 0},
        {"source(sun)", RAYS(source)},
        {"ended(left)", RAYS(stop)},
        {"ended(absorbed, tube)", RAYS(stop) | RAYS(segment_count) | STEP(object)},
        {"ended(absorbed, air)", RAYS(stop) | RAYS(segment_count) | STEP(object) | STEP(medium)},
        {"hit(tube)", RAYS(segment_count) | STEP(object)},
        {"hit(tube, reflect)", RAYS(segment_count) | STEP(object) | STEP(event)},
        {"hit(tube, face 1)", RAYS(segment_count) | STEP(object) | STEP(primitive)},
        {"event(reflect) or not medium(air)", RAYS(segment_count) | STEP(event) | STEP(medium)},
        {"surface(polished)", RAYS(segment_count) | STEP(object)},
        {"surface(white)", RAYS(segment_count) | RAYS(start) | STEP(object) | STEP(event) |
                               STEP(medium) | STEP(position) | STEP(normal)},
        {"segments > 2", RAYS(segment_count)},
        {"bounces > 2", RAYS(segment_count) | STEP(event)},
        {"flux > 2", RAYS(source) | RAYS(weight)},
        {"registered(sensor)", RAYS(registration_count) | SEEN(detector) | SEEN(registered)},
        {"crossed(sensor)", RAYS(registration_count) | SEEN(detector)},
        {"crossed(sensor, cells(1, 2))", RAYS(registration_count) | SEEN(detector) | SEEN(cell)},
        {"crossed(sensor, rect(1, 2, 3, 4) where time > 2)",
         RAYS(registration_count) | SEEN(detector) | SEEN(relative) | SEEN(optical_path)},
        {"angle(sensor) > 2",
         RAYS(registration_count) | SEEN(detector) | SEEN(registered) | SEEN(direction)},
    };
    struct test_scene t;
    test_scene_init(&t);
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        struct rmap_criterion *criterion = NULL;
        assert_int_equal(rmap_criterion_compile(row[i].text, &t.scene, &criterion, NULL), RMAP_OK);
        if (rmap_criterion_columns(criterion) != row[i].columns)
            fail_msg("%s: columns %llx, expected %llx", row[i].text,
                     (unsigned long long)rmap_criterion_columns(criterion),
                     (unsigned long long)row[i].columns);
        rmap_criterion_destroy(criterion);
    }
}

/* A portion in which lamp's rays met tube and were absorbed there, seen by the sensor. */
static void test_skipping(void **state)
{
    (void)state;
    const struct rmap_portion_summary summary = {.events = RMAP_EVENT_ABSORB,
                                                 .stops = 1u << RMAP_STOP_ABSORBED,
                                                 .sources = 1,
                                                 .detectors = 1,
                                                 .objects = {1u << 1}};
    static const struct {
        const char *text;
        bool may;
    } row[] = {
        {"all", true},
        {"not all", false},
        {"source(lamp)", true},
        {"source(sun)", false},
        {"not source(lamp)", false}, /* all of them are */
        {"not source(sun)", true},
        {"source(sun) == 0", true},
        {"source(lamp) == 0", false},
        {"hit(tube)", true},
        {"hit(lens)", false},
        {"hit(housing)", true},
        {"hit(lens) == 0", true},
        {"hit(lens) != 0", false},
        {"not hit(lens)", true},
        {"not not hit(lens)", false},
        {"not hit(tube)", true}, /* some met it, others need not have */
        {"hit(tube, reflect)", false},
        {"hit(tube, absorb)", true},
        {"event(reflect)", false},
        {"bounces > 0", false},
        {"bounces == 0", true},
        {"surface(polished)", false},
        {"surface(black)", true},
        {"medium(ink)", true}, /* media are not in the summary */
        {"ended(left)", false},
        {"ended(absorbed)", true},
        {"not ended(absorbed)", false},
        {"ended(absorbed, lens)", false},
        {"not ended(absorbed, tube)", true},
        {"ended(absorbed, ink)", true},
        {"registered(sensor)", true},
        {"registered(screen)", false},
        {"angle(screen) < 90", false},
        {"hit(lens) or hit(tube)", true},
        {"hit(lens) and hit(tube)", false},
        {"hit(lens) or event(left)", false},
        {"wavelength > 500", true},
    };
    struct test_scene t;
    test_scene_init(&t);
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        struct rmap_criterion *criterion = NULL;
        assert_int_equal(rmap_criterion_compile(row[i].text, &t.scene, &criterion, NULL), RMAP_OK);
        if (rmap_criterion_may_match(criterion, &summary) != row[i].may)
            fail_msg("%s: expected %s", row[i].text, row[i].may ? "maybe" : "no");
        rmap_criterion_destroy(criterion);
    }
}

static void test_last_ray(void **state)
{
    (void)state;
    /* may match, and no later one. */
    static const struct {
        const char *text;
        uint64_t last;
    } row[] = {
        {"all", UINT64_MAX},
        {"ray in 3..99", 99},
        {"ray == 7 and hit(tube)", 7},
        {"ray == 9007199254740993", 9007199254740993}, /* 2^53 + 1: no double */
        {"ray < 18446744073709551614", 18446744073709551613u},
        {"ray < 7.5", 7},
        {"ray <= 1e30", UINT64_MAX},
        {"ray <= 7 or ray == 12", 12},
        {"ray == 7 or hit(tube)", UINT64_MAX},
        {"not ray == 7", UINT64_MAX},
        {"ray != 7", UINT64_MAX},
        {"ray > 7", UINT64_MAX},
    };
    struct test_scene t;
    test_scene_init(&t);
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        struct rmap_criterion *criterion = NULL;
        assert_int_equal(rmap_criterion_compile(row[i].text, &t.scene, &criterion, NULL), RMAP_OK);
        assert_true(rmap_criterion_may_hold(criterion, row[i].last, row[i].last));
        assert_false(row[i].last < UINT64_MAX &&
                     rmap_criterion_may_hold(criterion, row[i].last + 1, UINT64_MAX));
        rmap_criterion_destroy(criterion);
    }
}

/* Every allocation fails once: an error, nothing leaked. */
static void test_out_of_memory(void **state)
{
    (void)state;
    const char *text = "registered(sensor, polygon(0,0,1,0,0,1) where x > 0) and hit(?ens.?) or "
                       "surface(reflectance < 0.1) and ended(absorbed, h*)";
    struct test_scene t;
    test_scene_init(&t);
    int64_t live = rmap_alloc_live();
    int n_failed = 0;
    for (int64_t fail_at = 1;; fail_at++) {
        struct rmap_criterion *criterion = NULL;
        struct rmap_error err = {0};
        rmap_alloc_fail_at(fail_at);
        enum rmap_status st = rmap_criterion_compile(text, &t.scene, &criterion, &err);
        rmap_alloc_fail_at(0);
        rmap_criterion_destroy(criterion);
        assert_int_equal(rmap_alloc_live(), live);
        if (st == RMAP_OK)
            break;
        assert_int_equal(st, RMAP_SYSTEM);
        assert_true(strlen(err.text) > 0);
        n_failed++;
    }
    assert_true(n_failed > 8);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_precedence), cmocka_unit_test(test_laws),
        cmocka_unit_test(test_many_terms), cmocka_unit_test(test_nesting),
        cmocka_unit_test(test_columns),    cmocka_unit_test(test_skipping),
        cmocka_unit_test(test_last_ray),   cmocka_unit_test(test_out_of_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
