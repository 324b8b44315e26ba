/* SPDX-License-Identifier: MIT
 *
 * Words, numbers and signs of a criterion text.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "analysis/criterion/criterion_lex.h"
#include "analysis/criterion/criterion_names.h"
#include "base/glob.h"

static void expect_kinds(const char *text, const enum rmap_token_kind *kind, size_t n)
{
    struct rmap_token token = {0};
    struct rmap_error err = {0};
    for (size_t i = 0; i < n; i++) {
        assert_int_equal(rmap_token_read(text, token.end, &token, &err), RMAP_OK);
        assert_int_equal(token.kind, kind[i]);
    }
    assert_int_equal(rmap_token_read(text, token.end, &token, &err), RMAP_OK);
    assert_int_equal(token.kind, RMAP_TOKEN_END);
}

static void test_signs(void **state)
{
    (void)state;
    const enum rmap_token_kind logic[] = {RMAP_TOKEN_NOT, RMAP_TOKEN_AND, RMAP_TOKEN_AND,
                                          RMAP_TOKEN_OR,  RMAP_TOKEN_OR,  RMAP_TOKEN_NOT,
                                          RMAP_TOKEN_AND, RMAP_TOKEN_OR};
    expect_kinds("! & && | || not and or", logic, 8);
    const enum rmap_token_kind relation[] = {RMAP_TOKEN_EQ, RMAP_TOKEN_NE, RMAP_TOKEN_LT,
                                             RMAP_TOKEN_LE, RMAP_TOKEN_GT, RMAP_TOKEN_GE};
    expect_kinds("==!=< <=> >=", relation, 6);
    const enum rmap_token_kind other[] = {RMAP_TOKEN_OPEN, RMAP_TOKEN_CLOSE, RMAP_TOKEN_COMMA,
                                          RMAP_TOKEN_RANGE, RMAP_TOKEN_AT};
    expect_kinds("(),..@", other, 5);
    const enum rmap_token_kind text[] = {RMAP_TOKEN_WORD, RMAP_TOKEN_QUOTED, RMAP_TOKEN_STRING};
    expect_kinds("lens.1* 'a ''b''' \"T@x\"", text, 3);
    const enum rmap_token_kind words[] = {RMAP_TOKEN_WORD, RMAP_TOKEN_WORD, RMAP_TOKEN_WORD};
    expect_kinds("notes android\torder", words, 3);
}

static void test_numbers(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        double number;
        size_t end;
    } row[] = {{"2..4", 2, 1},     {"2.5..4", 2.5, 3}, {"-3", -3, 2},       {"+.5", 0.5, 3},
               {"1e3", 1000, 3},   {"1e3m", 1000, 3},  {"2em", 2, 1},       {"120mm", 120, 3},
               {"1.e-2", 0.01, 5}, {"7.", 7, 2},       {"  0.25)", 0.25, 6}};
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        struct rmap_token token = {0};
        struct rmap_error err = {0};
        assert_int_equal(rmap_token_read(row[i].text, 0, &token, &err), RMAP_OK);
        assert_int_equal(token.kind, RMAP_TOKEN_NUMBER);
        assert_true(token.number == row[i].number);
        assert_int_equal(token.end, row[i].end);
    }
}

static void expect_error(const char *text, const char *message)
{
    struct rmap_token token = {0};
    struct rmap_error err = {0};
    assert_int_equal(rmap_token_read(text, 0, &token, &err), RMAP_INPUT);
    assert_string_equal(err.text, message);
}

static void test_errors(void **state)
{
    (void)state;
    expect_error("  'abc", "criterion:1:3: error: this quote is never closed\n    'abc\n    ^");
    expect_error("\"T", "criterion:1:1: error: this quote is never closed\n  \"T\n  ^");
    expect_error("#", "criterion:1:1: error: unexpected character '#'\n  #\n  ^");
    expect_error("\x01", "criterion:1:1: error: unexpected character with code 1\n  ?\n  ^");
    expect_error("= 2",
                 "criterion:1:1: error: unexpected '=' (equality is written '==')\n  = 2\n  ^");
    expect_error("1e999", "criterion:1:1: error: the number is too large\n  1e999\n  ^~~~~");
    char text[700] = {0};
    struct rmap_token token = {0};
    struct rmap_error err = {0};
    memset(text, 'a', sizeof text - 1);
    assert_int_equal(rmap_token_read(text, 0, &token, &err), RMAP_INPUT);
    memset(text, '1', sizeof text - 1);
    assert_int_equal(rmap_token_read(text, 0, &token, &err), RMAP_INPUT);
}

static void test_utf8(void **state)
{
    (void)state;
    struct rmap_error err = {0};
    assert_int_equal(rmap_criterion_check_utf8("a\xc3\xa4\xe2\x89\xa5\xf0\x9f\x94\xad", &err),
                     RMAP_OK);
    static const char *const bad[] = {"a\xff", "a\xc0\x80", "a\xed\xa0\x80", "a\xf5\x80\x80\x80",
                                      "a\xc3", "a\x80",     "a\xe2\x89"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        assert_int_equal(rmap_criterion_check_utf8(bad[i], &err), RMAP_INPUT);
        assert_non_null(strstr(err.text, "criterion:1:2: error: this is not UTF-8 text"));
    }
}

static void test_glob(void **state)
{
    (void)state;
    assert_true(rmap_glob("*", ""));
    assert_true(rmap_glob("lens*", "lens.edge.1"));
    assert_true(rmap_glob("*.?", "lens.1"));
    assert_true(rmap_glob("l*.e*1", "lens.edge.1"));
    assert_true(rmap_glob("n?me", "n\xc3\xa4me"));
    assert_true(rmap_glob("*\xa4me", "n\xc3\xa4me") == false);
    assert_false(rmap_glob("?", ""));
    assert_false(rmap_glob("lens", "lens.1"));
    assert_false(rmap_glob("*.?", "lens.10"));
}

static void test_token_name(void **state)
{
    (void)state;
    char name[RMAP_TOKEN_NAME_NBYTES + 1];
    struct rmap_token token = {0};
    assert_int_equal(rmap_token_read("'it''s odd'", 0, &token, NULL), RMAP_OK);
    rmap_token_name("'it''s odd'", &token, name);
    assert_string_equal(name, "it's odd");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_signs),  cmocka_unit_test(test_numbers),
        cmocka_unit_test(test_errors), cmocka_unit_test(test_utf8),
        cmocka_unit_test(test_glob),   cmocka_unit_test(test_token_name),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
