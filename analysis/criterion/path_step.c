/* SPDX-License-Identifier: MIT
 *
 * A step of a path: its letters, and the name of the place behind them.
 */
#include <string.h>

#include "analysis/criterion/criterion_word.h"
#include "analysis/criterion/path_step.h"
#include "base/alloc.h"

static void skip_blanks(struct rmap_path_reader *reader)
{
    while (reader->at < reader->end && strchr(" \t\r\n", reader->text[reader->at]))
        reader->at++;
}

char rmap_path_peek(struct rmap_path_reader *reader)
{
    skip_blanks(reader);
    return reader->at < reader->end ? reader->text[reader->at] : 0;
}

size_t rmap_path_code_point_end(const struct rmap_path_reader *reader)
{
    size_t to = reader->at + 1;
    while (to < reader->end && ((unsigned char)reader->text[to] & 0xc0) == 0x80)
        to++;
    return to;
}

static int letter_index(char c)
{
    const char *found = c ? strchr(RMAP_PATH_LETTERS, c) : NULL;
    return found ? (int)(found - RMAP_PATH_LETTERS) : -1;
}

static enum rmap_status fail_letter(const struct rmap_path_reader *reader)
{
    char c = reader->text[reader->at];
    int other = letter_index((char)(c ^ 0x20));
    if (c == '@')
        return RMAP_PATH_FAIL(reader, reader->at, reader->at + 1,
                              "a name follows a letter, as in T@name (any step there: .@name)");
    if ((unsigned char)c < 0x80 && other >= 0 && letter_index(c) < 0)
        return RMAP_PATH_FAIL(
            reader, reader->at, reader->at + 1,
            "'%c' is no letter of a step (did you mean '%c'? a step at a name: T@name)", c,
            RMAP_PATH_LETTERS[other]);
    return RMAP_PATH_FAIL(reader, reader->at, rmap_path_code_point_end(reader),
                          "expected a step: one of T R I D d S F O A X K E V, '.', [...] or (...)");
}

/* [TR] or [^A]; the bracket is next. */
static enum rmap_status read_set(struct rmap_path_reader *reader, uint32_t *letters)
{
    size_t open = reader->at++;
    bool inverse = rmap_path_peek(reader) == '^';
    if (inverse)
        reader->at++;
    for (char c = rmap_path_peek(reader); c != ']'; c = rmap_path_peek(reader)) {
        if (!c)
            return RMAP_PATH_FAIL(reader, open, open + 1, "this bracket is never closed");
        int letter = letter_index(c);
        if (letter < 0)
            return RMAP_PATH_FAIL(reader, reader->at, rmap_path_code_point_end(reader),
                                  "expected one of T R I D d S F O A X K E V or ']'");
        *letters |= 1u << letter;
        reader->at++;
    }
    reader->at++;
    if (!*letters)
        return RMAP_PATH_FAIL(reader, open, reader->at, "no letter stands between these brackets");
    if (inverse)
        *letters ^= RMAP_PATH_ANY;
    return RMAP_OK;
}

static bool is_name_start(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || (unsigned char)c >= 0x80;
}

static bool is_name_char(char c)
{
    return is_name_start(c) || (c >= '0' && c <= '9');
}

/* The longest [A-Za-z_]\w*(\.\w+)*, or a quoted name. Bytes beyond ASCII are letters here as they
 * are outside of paths. */
static enum rmap_status read_name(struct rmap_path_reader *reader, struct rmap_token *token)
{
    enum rmap_status st = RMAP_OK;
    const char *text = reader->text;
    char first = rmap_path_peek(reader);
    size_t to = reader->at;
    if (first == '\'') {
        RMAP_TRY(rmap_token_read(text, reader->at, token, reader->parser->err));
        if (token->end > reader->end)
            st = RMAP_PATH_FAIL(reader, reader->at, reader->at + 1, "this quote is never closed");
        reader->at = token->end;
        goto out;
    }
    if (!is_name_start(first))
        return RMAP_PATH_FAIL(
            reader, reader->at, first ? rmap_path_code_point_end(reader) : reader->at + 1,
            "expected a name behind '@'; one with other signs than letters, digits and _ "
            "stands in single quotes");
    while (to < reader->end && is_name_char(text[to])) {
        while (to < reader->end && is_name_char(text[to]))
            to++;
        if (to + 1 < reader->end && text[to] == '.' && is_name_char(text[to + 1]))
            to++;
    }
    *token = (struct rmap_token){.kind = RMAP_TOKEN_WORD, .begin = reader->at, .end = to};
    reader->at = to;
    if (to - token->begin > RMAP_TOKEN_NAME_NBYTES)
        st = RMAP_PATH_FAIL(reader, token->begin, to, "a word of %zu bytes is too long for a name",
                            to - token->begin);
out:
    return st;
}

static bool same_text(const struct rmap_path_reader *reader, const struct rmap_path_place *place,
                      const struct rmap_token *token)
{
    size_t nbytes = token->end - token->begin;
    return place->end - place->begin == nbytes &&
           memcmp(reader->text + place->begin, reader->text + token->begin, nbytes) == 0;
}

static enum rmap_status look_up(struct rmap_path_reader *reader, const struct rmap_token *token,
                                struct rmap_path_place *place)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_parser *parser = reader->parser;
    *place = (struct rmap_path_place){.begin = token->begin, .end = token->end};
    RMAP_TRY(
        rmap_parser_look_up(parser, token, RMAP_WANTED_OBJECT, &place->object, &place->is_object));
    RMAP_TRY(
        rmap_parser_look_up(parser, token, RMAP_WANTED_MEDIUM, &place->medium, &place->is_medium));
    RMAP_TRY(rmap_parser_look_up(parser, token, RMAP_WANTED_DETECTOR, &place->detector,
                                 &place->is_detector));
out:
    return st;
}

/* The place that a name stands for, looked up once per path. */
static enum rmap_status find_place(struct rmap_path_reader *reader, const struct rmap_token *token,
                                   int32_t *index_ret)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_regex *regex = reader->regex;
    for (size_t i = 0; i < regex->n_place; i++)
        if (same_text(reader, &regex->place[i], token)) {
            *index_ret = (int32_t)i;
            return RMAP_OK;
        }
    if (regex->n_place == RMAP_PATH_NAME_MAX)
        return RMAP_PATH_FAIL(reader, token->begin, token->end,
                              "this path is too complex: more than %d different names",
                              RMAP_PATH_NAME_MAX);
    RMAP_TRY(RMAP_RESERVE(regex->place, regex->place_cap, regex->n_place + 1, reader->parser->err));
    RMAP_TRY(look_up(reader, token, &regex->place[regex->n_place]));
    *index_ret = (int32_t)regex->n_place++;
out:
    return st;
}

/* A known name in the wrong place gets a hint how a path asks for it. */
static enum rmap_status fail_name(const struct rmap_path_reader *reader,
                                  const struct rmap_token *token, uint32_t letters,
                                  const struct rmap_path_place *place)
{
    const uint32_t detector = 1u << RMAP_PATH_LETTER_V;
    char name[RMAP_TOKEN_NAME_NBYTES + 1], shown[RMAP_SHOWN_NBYTES], written[RMAP_SHOWN_NBYTES];
    rmap_token_name(reader->text, token, name);
    rmap_criterion_shorten(name, shown);
    rmap_token_shorten(reader->text, token, written);
    if (place->is_detector)
        return RMAP_PATH_FAIL(reader, token->begin, token->end,
                              "'%s' is a detector, not an object (in a path: V@%s)", shown,
                              written);
    if (letters == detector && place->is_object)
        return RMAP_PATH_FAIL(
            reader, token->begin, token->end,
            "'%s' is no detector (V is for detectors; any step at an object: .@%s)", shown,
            written);
    if (place->is_medium)
        return RMAP_PATH_FAIL(reader, token->begin, token->end,
                              "'%s' is a medium; only A and S happen inside one (in a path: A@%s)",
                              shown, written);
    enum rmap_name_wanted wanted = RMAP_WANTED_OBJECT;
    if (letters == detector)
        wanted = RMAP_WANTED_DETECTOR;
    else if (letters & detector)
        wanted = RMAP_WANTED_ANYWHERE;
    else if (letters & RMAP_PATH_INSIDE)
        wanted = RMAP_WANTED_PLACE;
    return rmap_names_fail(reader->parser->names, reader->text, token, wanted, reader->parser->err);
}

/* The name behind an '@', which is next. */
static enum rmap_status read_place(struct rmap_path_reader *reader, uint32_t letters,
                                   int32_t *place)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_token token;
    reader->at++;
    RMAP_TRY(read_name(reader, &token));
    RMAP_TRY(find_place(reader, &token, place));
    const struct rmap_path_place *its = &reader->regex->place[*place];
    bool fits = (letters & RMAP_PATH_STEPS && its->is_object) ||
                (letters & RMAP_PATH_INSIDE && its->is_medium) ||
                (letters >> RMAP_PATH_LETTER_V && its->is_detector);
    if (!fits)
        st = fail_name(reader, &token, letters, its);
out:
    return st;
}

static enum rmap_status find_atom(struct rmap_path_reader *reader, struct rmap_path_atom atom,
                                  size_t begin, uint32_t *index_ret)
{
    struct rmap_path_regex *regex = reader->regex;
    for (size_t i = 0; i < regex->n_atom; i++)
        if (regex->atom[i].letters == atom.letters && regex->atom[i].place == atom.place) {
            *index_ret = (uint32_t)i;
            return RMAP_OK;
        }
    if (regex->n_atom == RMAP_PATH_ATOM_MAX)
        return RMAP_PATH_FAIL(reader, begin, reader->at,
                              "this path is too complex: more than %d different steps",
                              RMAP_PATH_ATOM_MAX);
    enum rmap_status st =
        RMAP_RESERVE(regex->atom, regex->atom_cap, regex->n_atom + 1, reader->parser->err);
    if (st != RMAP_OK)
        return st;
    *index_ret = (uint32_t)regex->n_atom;
    regex->atom[regex->n_atom++] = atom;
    return RMAP_OK;
}

enum rmap_status rmap_path_read_atom(struct rmap_path_reader *reader, uint32_t *atom_ret)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_atom atom = {0, -1};
    char c = rmap_path_peek(reader);
    int letter = letter_index(c);
    size_t begin = reader->at;
    if (c == '[') {
        RMAP_TRY(read_set(reader, &atom.letters));
    } else if (c == '.' || letter >= 0) {
        atom.letters = c == '.' ? (uint32_t)RMAP_PATH_ANY : 1u << letter;
        reader->at++;
    } else {
        return fail_letter(reader);
    }
    if (rmap_path_peek(reader) == '@')
        RMAP_TRY(read_place(reader, atom.letters, &atom.place));
    RMAP_TRY(find_atom(reader, atom, begin, atom_ret));
out:
    return st;
}
