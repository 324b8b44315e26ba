/* SPDX-License-Identifier: MIT
 *
 * docs/scene.md tells every key, type and word that the tables of the reader have, under the
 * heading that the table names, and its tables of keys have none that the reader does not know.
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

#include "io/scene/scene_field.h"

static char page[1 << 18];

static int read_page(void **state)
{
    (void)state;
    FILE *in = fopen(RAYMAP_SOURCE_DIR "/docs/scene.md", "rb");
    if (!in)
        return -1;
    size_t n = fread(page, 1, sizeof page - 1, in);
    fclose(in);
    return n > 0 ? 0 : -1;
}

/* The text under a heading of any depth, up to the next one of `##`. */
static char *section_of(const char *heading)
{
    char line[80];
    (void)snprintf(line, sizeof line, "# %s\n", heading);
    char *at = strstr(page, line);
    assert_non_null(at);
    char *end = strstr(at + 2, "\n## ");
    size_t len = end ? (size_t)(end - at) : strlen(at);
    char *text = malloc(len + 1);
    assert_non_null(text);
    memcpy(text, at, len);
    text[len] = 0;
    return text;
}

static bool in_word(char c)
{
    return isalnum((unsigned char)c) || c == '_' || c == '^';
}

/* Stands there as a word, within code or a code block. */
static bool tells(const char *text, const char *word)
{
    const size_t len = strlen(word);
    for (const char *at = text; (at = strstr(at, word)) != NULL; at++)
        if (!in_word(at[len]) && (at == text || !in_word(at[-1])))
            return true;
    return false;
}

static void check_words(const char *section, const char *text, const char *list)
{
    struct rmap_words words;
    rmap_words_split(list ? list : "", &words);
    for (size_t i = 0; i < words.n; i++)
        if (!tells(text, words.word[i]))
            fail_msg("'%s' is not told under '%s'", words.word[i], section);
}

static void test_every_key_is_told(void **state)
{
    const struct rmap_mapping *mapping;
    (void)state;
    for (size_t i = 0; (mapping = rmap_scene_mapping(i)) != NULL; i++) {
        char *text = section_of(mapping->section);
        check_words(mapping->section, text, mapping->types);
        for (size_t t = 0; t < RMAP_COUNT(mapping->type) && mapping->type[t].keys; t++)
            check_words(mapping->section, text, mapping->type[t].keys);
        for (size_t k = 0; k < RMAP_COUNT(mapping->key) && mapping->key[k].name; k++)
            check_words(mapping->section, text, mapping->key[k].words);
        free(text);
    }
}

static void test_every_gradient_is_told(void **state)
{
    static const struct rmap_field_model *(*const kind[])(size_t) = {
        rmap_field_model_analytic, rmap_field_model_made, rmap_field_model_from_file};
    const struct rmap_field_model *model;
    char *text = section_of("gradient media");
    (void)state;
    for (size_t k = 0; k < RMAP_COUNT(kind); k++)
        for (size_t i = 0; (model = kind[k](i)) != NULL; i++) {
            check_words("gradient media", text, model->type);
            for (size_t j = 0; j < RMAP_FIELD_KEY_MAX && model->parameter[j].name; j++)
                check_words("gradient media", text, model->parameter[j].name);
            for (size_t j = 0; j < RMAP_FIELD_KEY_MAX && model->key[j]; j++)
                check_words("gradient media", text, model->key[j]);
        }
    free(text);
}

/* Whether a mapping of this heading knows the key, or it is a section. */
static bool is_known(const char *heading, const char *word)
{
    const struct rmap_mapping *mapping;
    for (size_t i = 0; (mapping = rmap_scene_mapping(i)) != NULL; i++)
        for (size_t t = 0; t < RMAP_COUNT(mapping->type) && mapping->type[t].keys; t++)
            if ((mapping == &rmap_root_keys || strcmp(mapping->section, heading) == 0) &&
                tells(mapping->type[t].keys, word))
                return true;
    return false;
}

/* The first column of the tables headed "| key | ... |": `key`, `key: value`, `mapping.key`. */
static void test_every_told_key_is_known(void **state)
{
    static const char *const heading[] = {"Head",    "media",     "objects",
                                          "sources", "detectors", "cameras"};
    size_t n_key = 0;
    (void)state;
    for (size_t h = 0; h < RMAP_COUNT(heading); h++) {
        char *text = section_of(heading[h]), *rest = text, *line;
        bool inside = false;
        while ((line = strtok_r(rest, "\n", &rest)) != NULL) {
            char *cell_end = line[0] == '|' ? strchr(line + 1, '|') : NULL;
            inside = cell_end && (inside || strncmp(line, "| key |", 7) == 0) &&
                     strncmp(line, "### ", 4) != 0;
            if (strncmp(line, "### ", 4) == 0)
                break; /* what follows has tables of its own */
            if (!inside)
                continue;
            for (char *at = line; (at = strchr(at, '`')) != NULL && at < cell_end; at++) {
                char word[80];
                size_t len = strcspn(at + 1, "`: .");
                if (at[1 + len] == '.') { /* of a mapping in the head */
                    at += len + 1;
                    len = strcspn(at + 1, "`: ");
                }
                (void)snprintf(word, sizeof word, "%.*s", (int)len, at + 1);
                at = strchr(at + 1, '`');
                if (!is_known(heading[h], word))
                    fail_msg("'%s' under '%s' is no key", word, heading[h]);
                n_key++;
            }
        }
        free(text);
    }
    assert_true(n_key > 60);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_key_is_told),
        cmocka_unit_test(test_every_gradient_is_told),
        cmocka_unit_test(test_every_told_key_is_known),
    };
    return cmocka_run_group_tests(tests, read_page, NULL);
}
