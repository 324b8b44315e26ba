/* SPDX-License-Identifier: MIT
 *
 * Recursive descent over choice, sequence, quantifier, atom. Only parentheses recurse. Children
 * are linked from the last to the first: the automaton is built backwards.
 */
#include "analysis/path_regex.h"

#include <string.h>

#include "base/alloc.h"

struct reader {
    struct rmap_parser *parser;
    struct rmap_path_regex *regex;
    const char *text;
    size_t at, end; /* what is left of the string's inside */
    int depth;
};

#define FAIL(reader, from, to, ...)                                                                \
    rmap_criterion_fail((reader)->text, from, to, (reader)->parser->err, __VA_ARGS__)

static void skip_blanks(struct reader *reader)
{
    while (reader->at < reader->end && strchr(" \t\r\n", reader->text[reader->at]))
        reader->at++;
}

/* The next character that is no blank; 0 at the end. */
static char peek(struct reader *reader)
{
    skip_blanks(reader);
    return reader->at < reader->end ? reader->text[reader->at] : 0;
}

static size_t code_point_end(const struct reader *reader)
{
    size_t to = reader->at + 1;
    while (to < reader->end && ((unsigned char)reader->text[to] & 0xc0) == 0x80)
        to++;
    return to;
}

static enum rmap_status add_term(struct reader *reader, const struct rmap_path_term *term,
                                 int32_t *index_ret)
{
    struct rmap_path_regex *regex = reader->regex;
    void *block = regex->term;
    enum rmap_status st = rmap_reserve(&block, &regex->term_cap, regex->n_term + 1,
                                       sizeof *regex->term, reader->parser->err);
    if (st != RMAP_OK)
        return st;
    regex->term = block;
    *index_ret = (int32_t)regex->n_term;
    regex->term[regex->n_term++] = *term;
    return RMAP_OK;
}

static int letter_index(char c)
{
    const char *found = c ? strchr(RMAP_PATH_LETTERS, c) : NULL;
    return found ? (int)(found - RMAP_PATH_LETTERS) : -1;
}

static enum rmap_status fail_letter(const struct reader *reader)
{
    char c = reader->text[reader->at];
    int other = letter_index((char)(c ^ 0x20));
    if (c == '@')
        return FAIL(reader, reader->at, reader->at + 1,
                    "a name follows a letter, as in T@name (any step there: .@name)");
    if ((unsigned char)c < 0x80 && other >= 0 && letter_index(c) < 0)
        return FAIL(reader, reader->at, reader->at + 1,
                    "'%c' is no letter of a step (did you mean '%c'? a step at a name: T@name)", c,
                    RMAP_PATH_LETTERS[other]);
    return FAIL(reader, reader->at, code_point_end(reader),
                "expected a step: one of T R I D d S F O A X K E V, '.', [...] or (...)");
}

/* [TR] or [^A]; the bracket is next. */
static enum rmap_status read_set(struct reader *reader, uint32_t *letters)
{
    size_t open = reader->at++;
    bool inverse = peek(reader) == '^';
    if (inverse)
        reader->at++;
    for (char c = peek(reader); c != ']'; c = peek(reader)) {
        if (!c)
            return FAIL(reader, open, open + 1, "this bracket is never closed");
        int letter = letter_index(c);
        if (letter < 0)
            return FAIL(reader, reader->at, code_point_end(reader),
                        "expected one of T R I D d S F O A X K E V or ']'");
        *letters |= 1u << letter;
        reader->at++;
    }
    reader->at++;
    if (!*letters)
        return FAIL(reader, open, reader->at, "no letter stands between these brackets");
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
static enum rmap_status read_name(struct reader *reader, struct rmap_token *token)
{
    enum rmap_status st = RMAP_OK;
    const char *text = reader->text;
    char first = peek(reader);
    size_t to = reader->at;
    if (first == '\'') {
        RMAP_TRY(rmap_token_read(text, reader->at, token, reader->parser->err));
        if (token->end > reader->end)
            st = FAIL(reader, reader->at, reader->at + 1, "this quote is never closed");
        reader->at = token->end;
        goto out;
    }
    if (!is_name_start(first))
        return FAIL(reader, reader->at, first ? code_point_end(reader) : reader->at + 1,
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
        st = FAIL(reader, token->begin, to, "a word of %zu bytes is too long for a name",
                  to - token->begin);
out:
    return st;
}

static bool same_text(const struct reader *reader, const struct rmap_path_place *place,
                      const struct rmap_token *token)
{
    size_t nbytes = token->end - token->begin;
    return place->end - place->begin == nbytes &&
           memcmp(reader->text + place->begin, reader->text + token->begin, nbytes) == 0;
}

static enum rmap_status look_up(struct reader *reader, const struct rmap_token *token,
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
static enum rmap_status find_place(struct reader *reader, const struct rmap_token *token,
                                   int32_t *index_ret)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_regex *regex = reader->regex;
    void *block = regex->place;
    for (size_t i = 0; i < regex->n_place; i++)
        if (same_text(reader, &regex->place[i], token)) {
            *index_ret = (int32_t)i;
            return RMAP_OK;
        }
    if (regex->n_place == RMAP_PATH_NAME_MAX)
        return FAIL(reader, token->begin, token->end,
                    "this path is too complex: more than %d different names", RMAP_PATH_NAME_MAX);
    RMAP_TRY(rmap_reserve(&block, &regex->place_cap, regex->n_place + 1, sizeof *regex->place,
                          reader->parser->err));
    regex->place = block;
    RMAP_TRY(look_up(reader, token, &regex->place[regex->n_place]));
    *index_ret = (int32_t)regex->n_place++;
out:
    return st;
}

/* A known name in the wrong place gets a hint how a path asks for it. */
static enum rmap_status fail_name(const struct reader *reader, const struct rmap_token *token,
                                  uint32_t letters, const struct rmap_path_place *place)
{
    const uint32_t detector = 1u << RMAP_PATH_LETTER_V;
    char name[RMAP_TOKEN_NAME_NBYTES + 1], shown[RMAP_SHOWN_NBYTES], written[RMAP_SHOWN_NBYTES];
    rmap_token_name(reader->text, token, name);
    rmap_criterion_shorten(name, shown);
    rmap_token_shorten(reader->text, token, written);
    if (place->is_detector)
        return FAIL(reader, token->begin, token->end,
                    "'%s' is a detector, not an object (in a path: V@%s)", shown, written);
    if (letters == detector && place->is_object)
        return FAIL(reader, token->begin, token->end,
                    "'%s' is no detector (V is for detectors; any step at an object: .@%s)", shown,
                    written);
    if (place->is_medium)
        return FAIL(reader, token->begin, token->end,
                    "'%s' is a medium; only A and S happen inside one (in a path: A@%s)", shown,
                    written);
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
static enum rmap_status read_place(struct reader *reader, uint32_t letters, int32_t *place)
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

static enum rmap_status find_atom(struct reader *reader, struct rmap_path_atom atom, size_t begin,
                                  uint32_t *index_ret)
{
    struct rmap_path_regex *regex = reader->regex;
    void *block = regex->atom;
    for (size_t i = 0; i < regex->n_atom; i++)
        if (regex->atom[i].letters == atom.letters && regex->atom[i].place == atom.place) {
            *index_ret = (uint32_t)i;
            return RMAP_OK;
        }
    if (regex->n_atom == RMAP_PATH_ATOM_MAX)
        return FAIL(reader, begin, reader->at,
                    "this path is too complex: more than %d different steps", RMAP_PATH_ATOM_MAX);
    enum rmap_status st = rmap_reserve(&block, &regex->atom_cap, regex->n_atom + 1,
                                       sizeof *regex->atom, reader->parser->err);
    if (st != RMAP_OK)
        return st;
    regex->atom = block;
    *index_ret = (uint32_t)regex->n_atom;
    regex->atom[regex->n_atom++] = atom;
    return RMAP_OK;
}

static enum rmap_status read_step(struct reader *reader, int32_t *term_ret)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_atom atom = {0, -1};
    struct rmap_path_term term = {.kind = RMAP_PATH_ATOM, .last = -1, .prev = -1};
    char c = peek(reader);
    int letter = letter_index(c);
    term.begin = reader->at;
    if (c == '[') {
        RMAP_TRY(read_set(reader, &atom.letters));
    } else if (c == '.' || letter >= 0) {
        atom.letters = c == '.' ? (uint32_t)RMAP_PATH_ANY : 1u << letter;
        reader->at++;
    } else {
        return fail_letter(reader);
    }
    if (peek(reader) == '@')
        RMAP_TRY(read_place(reader, atom.letters, &atom.place));
    RMAP_TRY(find_atom(reader, atom, term.begin, &term.atom));
    term.end = reader->at;
    RMAP_TRY(add_term(reader, &term, term_ret));
out:
    return st;
}

/* A number of a quantifier; more than any history has stays more than that. */
static enum rmap_status read_count(struct reader *reader, uint32_t *count)
{
    char c = peek(reader);
    *count = 0;
    if (c < '0' || c > '9')
        return FAIL(reader, reader->at,
                    reader->at < reader->end ? code_point_end(reader) : reader->at + 1,
                    "expected a number of times, as in {2} or {2,4}");
    for (; reader->at < reader->end && reader->text[reader->at] >= '0' &&
           reader->text[reader->at] <= '9';
         reader->at++)
        if (*count <= RMAP_PATH_REPEAT_MAX)
            *count = *count * 10 + (uint32_t)(reader->text[reader->at] - '0');
    return RMAP_OK;
}

/* {n}, {n,} or {n,m}; the brace is next. */
static enum rmap_status read_counts(struct reader *reader, struct rmap_path_term *term)
{
    enum rmap_status st = RMAP_OK;
    reader->at++;
    RMAP_TRY(read_count(reader, &term->least));
    term->most = term->least;
    if (peek(reader) == ',') {
        reader->at++;
        term->most = RMAP_PATH_UNBOUNDED;
        if (peek(reader) != '}')
            RMAP_TRY(read_count(reader, &term->most));
    }
    if (peek(reader) != '}')
        return FAIL(reader, reader->at, reader->at + 1, "expected ',' or '}'");
    reader->at++;
    if (term->most < term->least)
        st = FAIL(reader, term->begin, reader->at, "the second number is less than the first");
    else if (term->least > RMAP_PATH_REPEAT_MAX ||
             (term->most != RMAP_PATH_UNBOUNDED && term->most > RMAP_PATH_REPEAT_MAX))
        st = FAIL(reader, term->begin, reader->at, "this path is too complex: more than %d times",
                  RMAP_PATH_REPEAT_MAX);
out:
    return st;
}

static bool at_quantifier(struct reader *reader)
{
    char c = peek(reader);
    return c && strchr("*+?{", c);
}

/* Wraps the term in the quantifier that stands behind it, if any. */
static enum rmap_status read_quantifier(struct reader *reader, int32_t *term_ret)
{
    enum rmap_status st = RMAP_OK;
    if (!at_quantifier(reader))
        return RMAP_OK;
    char c = reader->text[reader->at];
    struct rmap_path_term term = {.kind = RMAP_PATH_REPEAT,
                                  .last = *term_ret,
                                  .prev = -1,
                                  .begin = reader->at,
                                  .least = c == '+',
                                  .most = c == '?' ? 1 : RMAP_PATH_UNBOUNDED};
    if (c == '{')
        RMAP_TRY(read_counts(reader, &term));
    else
        reader->at++;
    term.end = reader->at;
    if (at_quantifier(reader))
        return FAIL(reader, reader->at, reader->at + 1,
                    "one quantifier behind another: write parentheses between them");
    RMAP_TRY(add_term(reader, &term, term_ret));
out:
    return st;
}

static enum rmap_status read_choice(struct reader *reader, int32_t *term_ret);

static enum rmap_status read_parentheses(struct reader *reader, int32_t *term_ret)
{
    enum rmap_status st = RMAP_OK;
    size_t open = reader->at++;
    if (++reader->depth > RMAP_PATH_DEPTH_MAX)
        return FAIL(reader, open, open + 1, "more than %d nested parentheses", RMAP_PATH_DEPTH_MAX);
    RMAP_TRY(read_choice(reader, term_ret));
    if (peek(reader) != ')')
        return FAIL(reader, open, open + 1, "this parenthesis is never closed");
    reader->at++;
    reader->depth--;
out:
    return st;
}

/* Terms side by side: the only one, or a parent of all. */
struct row {
    int32_t term; /* -1: none yet */
    bool is_parent;
};

static enum rmap_status join(struct reader *reader, enum rmap_path_term_kind kind, int32_t child,
                             struct row *row)
{
    if (row->term < 0) {
        row->term = child;
        return RMAP_OK;
    }
    if (!row->is_parent) {
        struct rmap_path_term parent = {.kind = kind, .last = row->term, .prev = -1};
        enum rmap_status st = add_term(reader, &parent, &row->term);
        if (st != RMAP_OK)
            return st;
        row->is_parent = true;
    }
    struct rmap_path_term *term = reader->regex->term;
    term[child].prev = term[row->term].last;
    term[row->term].last = child;
    return RMAP_OK;
}

static enum rmap_status read_sequence(struct reader *reader, int32_t *term_ret)
{
    enum rmap_status st = RMAP_OK;
    struct row row = {.term = -1};
    for (char c = peek(reader); c && c != '|' && c != ')'; c = peek(reader)) {
        int32_t term = -1;
        if (c == '(')
            RMAP_TRY(read_parentheses(reader, &term));
        else if (at_quantifier(reader))
            return FAIL(reader, reader->at, reader->at + 1,
                        "there is nothing before '%c' to repeat", c);
        else
            RMAP_TRY(read_step(reader, &term));
        RMAP_TRY(read_quantifier(reader, &term));
        RMAP_TRY(join(reader, RMAP_PATH_SEQUENCE, term, &row));
    }
    if (row.term < 0)
        return FAIL(reader, reader->at, reader->at + 1,
                    "expected a step here ('?' makes one optional)");
    *term_ret = row.term;
out:
    return st;
}

static enum rmap_status read_choice(struct reader *reader, int32_t *term_ret)
{
    enum rmap_status st = RMAP_OK;
    struct row row = {.term = -1};
    for (;;) {
        int32_t term = -1;
        RMAP_TRY(read_sequence(reader, &term));
        RMAP_TRY(join(reader, RMAP_PATH_CHOICE, term, &row));
        if (peek(reader) != '|')
            break;
        reader->at++;
    }
    *term_ret = row.term;
out:
    return st;
}

enum rmap_status rmap_path_regex_parse(struct rmap_parser *parser, const struct rmap_token *string,
                                       struct rmap_path_regex *regex)
{
    enum rmap_status st = RMAP_OK;
    struct reader reader = {.parser = parser,
                            .regex = regex,
                            .text = parser->text,
                            .at = string->begin + 1,
                            .end = string->end - 1};
    if (!peek(&reader))
        return RMAP_PARSER_FAIL(parser, string, "the path is empty (any history: \".*\")");
    RMAP_TRY(read_choice(&reader, &regex->root));
    if (peek(&reader) == ')')
        st = FAIL(&reader, reader.at, reader.at + 1, "no parenthesis is open here");
out:
    return st;
}

void rmap_path_regex_fini(struct rmap_path_regex *regex)
{
    rmap_free(regex->place);
    rmap_free(regex->atom);
    rmap_free(regex->term);
    *regex = (struct rmap_path_regex){0};
}
