/* SPDX-License-Identifier: MIT
 *
 * Recursive descent over choice, sequence, quantifier, atom. Only parentheses recurse. Children
 * are linked from the last to the first: the automaton is built backwards.
 */
#include <string.h>

#include "analysis/criterion/path_step.h"
#include "base/alloc.h"

static enum rmap_status add_term(struct rmap_path_reader *reader, const struct rmap_path_term *term,
                                 int32_t *index_ret)
{
    struct rmap_path_regex *regex = reader->regex;
    enum rmap_status st =
        RMAP_RESERVE(regex->term, regex->term_cap, regex->n_term + 1, reader->parser->err);
    if (st != RMAP_OK)
        return st;
    *index_ret = (int32_t)regex->n_term;
    regex->term[regex->n_term++] = *term;
    return RMAP_OK;
}

static enum rmap_status read_step(struct rmap_path_reader *reader, int32_t *term_ret)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_term term = {.kind = RMAP_PATH_ATOM, .last = -1, .prev = -1};
    (void)rmap_path_peek(reader);
    term.begin = reader->at;
    RMAP_TRY(rmap_path_read_atom(reader, &term.atom));
    term.end = reader->at;
    RMAP_TRY(add_term(reader, &term, term_ret));
out:
    return st;
}

/* A number of a quantifier; more than any history has stays more than that. */
static enum rmap_status read_count(struct rmap_path_reader *reader, uint32_t *count)
{
    char c = rmap_path_peek(reader);
    *count = 0;
    if (c < '0' || c > '9')
        return RMAP_PATH_FAIL(reader, reader->at,
                              reader->at < reader->end ? rmap_path_code_point_end(reader)
                                                       : reader->at + 1,
                              "expected a number of times, as in {2} or {2,4}");
    for (; reader->at < reader->end && reader->text[reader->at] >= '0' &&
           reader->text[reader->at] <= '9';
         reader->at++)
        if (*count <= RMAP_PATH_REPEAT_MAX)
            *count = *count * 10 + (uint32_t)(reader->text[reader->at] - '0');
    return RMAP_OK;
}

/* {n}, {n,} or {n,m}; the brace is next. */
static enum rmap_status read_counts(struct rmap_path_reader *reader, struct rmap_path_term *term)
{
    enum rmap_status st = RMAP_OK;
    reader->at++;
    RMAP_TRY(read_count(reader, &term->least));
    term->most = term->least;
    if (rmap_path_peek(reader) == ',') {
        reader->at++;
        term->most = RMAP_PATH_UNBOUNDED;
        if (rmap_path_peek(reader) != '}')
            RMAP_TRY(read_count(reader, &term->most));
    }
    if (rmap_path_peek(reader) != '}')
        return RMAP_PATH_FAIL(reader, reader->at, reader->at + 1, "expected ',' or '}'");
    reader->at++;
    if (term->most < term->least)
        st = RMAP_PATH_FAIL(reader, term->begin, reader->at,
                            "the second number is less than the first");
    else if (term->least > RMAP_PATH_REPEAT_MAX ||
             (term->most != RMAP_PATH_UNBOUNDED && term->most > RMAP_PATH_REPEAT_MAX))
        st = RMAP_PATH_FAIL(reader, term->begin, reader->at,
                            "this path is too complex: more than %d times", RMAP_PATH_REPEAT_MAX);
out:
    return st;
}

static bool at_quantifier(struct rmap_path_reader *reader)
{
    char c = rmap_path_peek(reader);
    return c && strchr("*+?{", c);
}

/* Wraps the term in the quantifier that stands behind it, if any. */
static enum rmap_status read_quantifier(struct rmap_path_reader *reader, int32_t *term_ret)
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
        return RMAP_PATH_FAIL(reader, reader->at, reader->at + 1,
                              "one quantifier behind another: write parentheses between them");
    RMAP_TRY(add_term(reader, &term, term_ret));
out:
    return st;
}

static enum rmap_status read_choice(struct rmap_path_reader *reader, int32_t *term_ret);

static enum rmap_status read_parentheses(struct rmap_path_reader *reader, int32_t *term_ret)
{
    enum rmap_status st = RMAP_OK;
    size_t open = reader->at++;
    if (++reader->depth > RMAP_PATH_DEPTH_MAX)
        return RMAP_PATH_FAIL(reader, open, open + 1, "more than %d nested parentheses",
                              RMAP_PATH_DEPTH_MAX);
    RMAP_TRY(read_choice(reader, term_ret));
    if (rmap_path_peek(reader) != ')')
        return RMAP_PATH_FAIL(reader, open, open + 1, "this parenthesis is never closed");
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

static enum rmap_status join(struct rmap_path_reader *reader, enum rmap_path_term_kind kind,
                             int32_t child, struct row *row)
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

static enum rmap_status read_sequence(struct rmap_path_reader *reader, int32_t *term_ret)
{
    enum rmap_status st = RMAP_OK;
    struct row row = {.term = -1};
    for (char c = rmap_path_peek(reader); c && c != '|' && c != ')'; c = rmap_path_peek(reader)) {
        int32_t term = -1;
        if (c == '(')
            RMAP_TRY(read_parentheses(reader, &term));
        else if (at_quantifier(reader))
            return RMAP_PATH_FAIL(reader, reader->at, reader->at + 1,
                                  "there is nothing before '%c' to repeat", c);
        else
            RMAP_TRY(read_step(reader, &term));
        RMAP_TRY(read_quantifier(reader, &term));
        RMAP_TRY(join(reader, RMAP_PATH_SEQUENCE, term, &row));
    }
    if (row.term < 0)
        return RMAP_PATH_FAIL(reader, reader->at, reader->at + 1,
                              "expected a step here ('?' makes one optional)");
    *term_ret = row.term;
out:
    return st;
}

static enum rmap_status read_choice(struct rmap_path_reader *reader, int32_t *term_ret)
{
    enum rmap_status st = RMAP_OK;
    struct row row = {.term = -1};
    for (;;) {
        int32_t term = -1;
        RMAP_TRY(read_sequence(reader, &term));
        RMAP_TRY(join(reader, RMAP_PATH_CHOICE, term, &row));
        if (rmap_path_peek(reader) != '|')
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
    struct rmap_path_reader reader = {.parser = parser,
                                      .regex = regex,
                                      .text = parser->text,
                                      .at = string->begin + 1,
                                      .end = string->end - 1};
    if (!rmap_path_peek(&reader))
        return RMAP_PARSER_FAIL(parser, string, "the path is empty (any history: \".*\")");
    RMAP_TRY(read_choice(&reader, &regex->root));
    if (rmap_path_peek(&reader) == ')')
        st = RMAP_PATH_FAIL(&reader, reader.at, reader.at + 1, "no parenthesis is open here");
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
