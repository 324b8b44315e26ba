/* SPDX-License-Identifier: MIT */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "base/visible_text.h"

/* In pieces of any length, since streams cut where they like. */
static void check(const char *given, const char *shown)
{
    const size_t nbytes = strlen(given);
    for (size_t step = 1; step <= nbytes; step++) {
        struct rmap_visible_text state = {0};
        char out[RMAP_VISIBLE_NBYTES(256)];
        size_t n = 0;
        for (size_t at = 0; at < nbytes; at += step)
            n += rmap_visible_text(&state, given + at, nbytes - at < step ? nbytes - at : step,
                                   out + n);
        out[n] = '\0';
        assert_string_equal(out, shown);
    }
}

static void test_plain(void **unused)
{
    (void)unused;
    check("a lens, 50 mm\tf/2\n", "a lens, 50 mm\tf/2\n");
    check("Gl\u00fchlampe \u03bb \u5149 \u05d0\u05d1 \U0001f4a1\n",
          "Gl\u00fchlampe \u03bb \u5149 \u05d0\u05d1 \U0001f4a1\n");
}

static void test_controls(void **unused)
{
    (void)unused;
    check("\x1b[2J\r\b\x7f.", "\\u001b[2J\\u000d\\u0008\\u007f.");
    check("\xc2\x9b"
          "31m \xc2\x85.",
          "\\u009b31m \\u0085.");
    check("a\u202ecba\u2066\u200f\u061c.", "a\\u202ecba\\u2066\\u200f\\u061c.");
}

static void test_no_utf8(void **unused)
{
    (void)unused;
    check("\x9b"
          "31m",
          "\\x9b31m");                                              /* C1 as one byte */
    check("\xc0\x9b \xe0\x82\x9b.", "\\xc0\\x9b \\xe0\\x82\\x9b."); /* overlong forms of it */
    check("\xed\xa0\x80 \xf4\x90\x80\x80 \xff.", "\\xed\\xa0\\x80 \\xf4\\x90\\x80\\x80 \\xff.");
    check("\xe2\x80"
          "a\xe2\xe2\x80\xae.",
          "\\xe2\\x80a\\xe2\\u202e.");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_plain),
        cmocka_unit_test(test_controls),
        cmocka_unit_test(test_no_utf8),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
