/* SPDX-License-Identifier: MIT
 *
 * Mutated criteria: whatever the text, compiling ends in a criterion that evaluates to 0s and 1s
 * or in a message with a place. Seeded, so a failure can be had again.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "analysis/criterion/criterion.h"
#include "analysis/criterion/criterion_lex.h"
#include "base/alloc.h"
#include "base/rng.h"
#include "tests/criterion_scene.h"

enum { N_RAY = 9, LONGEST = 400, N_ROUND = 60000 };

static const char *const seed_text[] = {
    "all",
    "hit(lens*, reflect_specular) >= 2 and not registered(sensor)",
    "hit(tube, face 0..2, absorb) | hit('odd n\xc3\xa4me', triangle 0)",
    "surface(reflectance < 0.1, absorb) in 1..3 or surface(black)",
    "registered(sensor, rect(-1 mm, 0, 1e1, .5) where angle < 10 deg and (x > 0 or !y != 2))",
    "crossed(far, polygon(0,0, 1,0, 0,1, rel)) && registered(s*, cells(0..3, 4))",
    "registered(screen, ellipse(0, 0, 1, 2)) == 0 or time(screen) < 2 ns",
    "ended(absorbed, ink) or ended(left) and segments in 2..4 & bounces > 1",
    "wavelength in 0.4..0.6 um and flux > 1 mW and path_length < 1 m and ray in 3..5",
    "medium(*) > 2 or source(?un) and (event(scatter) or optical_path >= 3)",
    "path(\"T@lens.1+ R@'l*' .* V@sensor\") and not path(\"[^AV]{1,3} (S|A@ink)*\")",
    "path(\"([TR]@lens X?)+ .@housing{2,}\") == 0 and @ghost",
};
static const char *const splice[] = {
    "(",       ")",     ",",
    "..",      "'",     "\"",
    "not ",    " and ", " or ",
    " in ",    "==",    "!=",
    "<",       ">=",    "*",
    "?",       "-1",    "1e9",
    "@",       "all",   "hit(",
    "lens",    "rel",   "mm",
    "\n",      "\t",    "\xff",
    "\xc3",    "0",     "99999999999",
    ".",       "e",     "registered(sensor",
    " where ", "face ", "let ",
    "path(\"", "[^",    "{2,9}",
    "V@",      "+",     "|",
};

struct dice {
    uint64_t round;
    uint32_t draw;
};

static size_t roll(struct dice *dice, size_t n)
{
    double u[4];
    rmap_rng(2024, dice->round, dice->draw++, 0, u);
    return (size_t)(u[0] * (double)n);
}

/* Replaces n bytes at `at` by the piece, as far as there is room. */
static void replace(char *text, size_t at, size_t n, const char *piece)
{
    size_t len = strlen(text), more = strlen(piece);
    if (at + n > len)
        n = len - at;
    if (len - n + more >= LONGEST)
        return;
    memmove(text + at + more, text + at + n, len - at - n + 1);
    memcpy(text + at, piece, more);
}

static void mutate(struct dice *dice, char *text)
{
    size_t n_seed = sizeof seed_text / sizeof *seed_text;
    size_t n_splice = sizeof splice / sizeof *splice;
    memset(text, 0, LONGEST);
    replace(text, 0, 0, seed_text[roll(dice, n_seed)]);
    for (size_t k = roll(dice, 5); k > 0; k--) {
        size_t at = roll(dice, strlen(text) + 1);
        char other[LONGEST] = {0};
        switch (roll(dice, 4)) {
        case 0:
            replace(text, at, 1 + roll(dice, 6), "");
            break;
        case 1:
            replace(text, at, roll(dice, 3), splice[roll(dice, n_splice)]);
            break;
        case 2:
            other[0] = (char)(1 + roll(dice, 255));
            replace(text, at, 1, other);
            break;
        default:
            memcpy(other, text + at, roll(dice, strlen(text) - at + 1));
            replace(text, roll(dice, strlen(text) + 1), 0, other);
            break;
        }
    }
}

static struct rmap_portion *make_portion(void)
{
    struct rmap_portion *portion = NULL;
    assert_int_equal(rmap_portion_create(N_RAY, 3, &portion, NULL), RMAP_OK);
    for (int i = 0; i < N_RAY; i++) {
        assert_true(test_add_ray(portion, &(struct test_ray){.id = (uint64_t)i, .source = i % 2}));
        for (int s = 0; s < i; s++)
            assert_true(test_add_step(portion, &(struct test_step){.object = s % 7 - 1,
                                                                   .event = 1u << s,
                                                                   .medium = 1,
                                                                   .normal = {0, 0, 1}}));
        assert_true(test_add_registration(
            portion, &(struct test_registration){.detector = i % 3, .registered = 1}));
    }
    return portion;
}

static void test_mutations(void **state)
{
    (void)state;
    static const double flux_per_weight[] = {1.0, 1.0};
    struct test_scene t;
    test_scene_init(&t);
    struct rmap_portion *portion = make_portion();
    int64_t live = rmap_alloc_live();
    size_t n_good = 0;
    for (uint64_t round = 0; round < N_ROUND; round++) {
        struct dice dice = {round, 0};
        char text[LONGEST];
        struct rmap_criterion *criterion = NULL;
        struct rmap_error err = {0};
        uint8_t match[N_RAY];
        mutate(&dice, text);
        enum rmap_status st = rmap_criterion_compile(text, &t.scene, &criterion, &err);
        if (st == RMAP_OK) {
            n_good++;
            assert_int_equal(
                rmap_criterion_evaluate(criterion, portion, flux_per_weight, match, &err), RMAP_OK);
            for (int i = 0; i < N_RAY; i++)
                assert_in_range(match[i], 0, 1);
        } else {
            assert_int_equal(st, RMAP_INPUT);
            assert_memory_equal(err.text, "criterion:", 10);
            assert_non_null(strstr(err.text, ": error: "));
            assert_non_null(strchr(err.text, '^'));
            assert_int_equal(rmap_criterion_check_utf8(err.text, NULL), RMAP_OK);
        }
        rmap_criterion_destroy(criterion);
        assert_int_equal(rmap_alloc_live(), live);
    }
    /* Both roads are walked. */
    assert_in_range(n_good, N_ROUND / 10, N_ROUND - N_ROUND / 10);
    rmap_portion_destroy(portion);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_mutations)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
