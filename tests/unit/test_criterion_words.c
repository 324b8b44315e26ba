/* SPDX-License-Identifier: MIT
 *
 * The table of words is the language's: every word of the examples in docs/criterion.md that is no
 * name of its scene is in it, and every word in it stands on that page or on that of statistics, or
 * is the name of a scatter model, which docs/scene.md lists.
 */
#include <ctype.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "analysis/criterion/criterion_word.h"

static char *page(const char *name)
{
    char path[512];
    (void)snprintf(path, sizeof path, "%s/docs/%s", RAYMAP_SOURCE_DIR, name);
    FILE *in = fopen(path, "rb");
    assert_non_null(in);
    char *text = calloc(1, 1 << 20);
    assert_non_null(text);
    assert_true(fread(text, 1, (1 << 20) - 1, in) > 0);
    fclose(in);
    return text;
}

static bool is_word(const char *text, size_t len)
{
    const char *word;
    for (size_t i = 0; (word = rmap_criterion_word(i)) != NULL; i++)
        if (strlen(word) == len && strncmp(word, text, len) == 0)
            return true;
    return false;
}

static bool in_word(char c)
{
    return isalnum((unsigned char)c) || c == '_' || c == '.' || c == '*' || c == '?' || (c & 0x80);
}

/* A unit behind a number, or a name: of the scene, which stands behind a parenthesis or a comma. */
static bool is_other(const char *line, const char *at)
{
    while (at > line && at[-1] == ' ')
        at--;
    return at > line && (isdigit((unsigned char)at[-1]) || at[-1] == '@');
}

/* Names are arguments of these; what else stands in parentheses is the language's. */
static bool takes_name(const char *line, const char *at)
{
    static const char *const test[] = {"hit",        "source",  "medium", "path_length",  "surface",
                                       "registered", "crossed", "after",  "at",           "x",
                                       "y",          "angle",   "time",   "optical_path", "world_x",
                                       "world_y",    "world_z"};
    const char *open = at;
    while (open > line && *open != '(')
        open--;
    const char *begin = open;
    while (begin > line && in_word(begin[-1]))
        begin--;
    for (size_t i = 0; i < sizeof test / sizeof *test; i++)
        if (*open == '(' && at == open + 1 && strlen(test[i]) == (size_t)(open - begin) &&
            strncmp(test[i], begin, strlen(test[i])) == 0)
            return true;
    return *open == '(' && strncmp(begin, "ended(", 6) == 0 && at > open + 1 && at[-1] == ' ';
}

static void check_line(const char *line, size_t *n_word)
{
    char quote = 0;
    for (const char *at = line; *at && *at != '\n' && (*at != '#' || quote); at++) {
        if (quote || *at == '\'' || *at == '"') {
            quote = !quote ? *at : *at == quote ? 0 : quote;
            continue;
        }
        if (!isalpha((unsigned char)*at) || (at > line && in_word(at[-1])))
            continue;
        size_t len = 1;
        while (in_word(at[len]))
            len++;
        if (is_other(line, at))
            continue;
        if (!is_word(at, len) && !takes_name(line, at))
            fail_msg("'%.*s' is not in the table: %.60s", (int)len, at, line);
        (*n_word)++;
    }
}

static void test_page_is_known(void **state)
{
    (void)state;
    char *text = page("criterion.md");
    size_t n_word = 0;
    bool inside = false;
    for (char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n")) {
        if (strncmp(line, "```", 3) == 0)
            inside = strcmp(line, "```criterion") == 0;
        else if (inside)
            check_line(line, &n_word);
    }
    assert_true(n_word > 250);
    free(text);
}

/* Stands in the first column of the section's tables, as in | `ggx`, `beckmann` |. */
static bool is_listed(const char *section, const char *word)
{
    char quoted[80];
    (void)snprintf(quoted, sizeof quoted, "`%s`", word);
    for (const char *at = section; (at = strstr(at, "\n| `")) != NULL; at += 2) {
        const char *found = strstr(at, quoted), *cell_end = strchr(at + 3, '|');
        if (found && found < cell_end)
            return true;
    }
    return false;
}

static void test_table_is_told(void **state)
{
    (void)state;
    char *criterion = page("criterion.md"), *statistics = page("statistics.md"),
         *scene = page("scene.md"), *models = strstr(scene, "\n### scatter models\n");
    assert_non_null(models);
    *strstr(models + 1, "\n### ") = '\0';
    const char *word;
    for (size_t i = 0; (word = rmap_criterion_word(i)) != NULL; i++) {
        const char *at = strstr(criterion, word);
        while (at && (in_word(at[-1]) || in_word(at[strlen(word)])))
            at = strstr(at + 1, word);
        if (!at && !strstr(statistics, word) && !is_listed(models, word))
            fail_msg("'%s' stands on no page", word);
    }
    free(criterion);
    free(statistics);
    free(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_page_is_known),
        cmocka_unit_test(test_table_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
