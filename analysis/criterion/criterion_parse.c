/* SPDX-License-Identifier: MIT
 *
 * Recursive descent: or over and over not over parentheses and tests. Only parentheses recurse,
 * to a stated depth; chains of and, or, not are loops.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "analysis/criterion/criterion_parser.h"
#include "base/alloc.h"

enum rmap_status rmap_parser_advance(struct rmap_parser *parser)
{
    parser->taken_end = parser->token.end;
    enum rmap_status st =
        rmap_token_read(parser->text, parser->token.end, &parser->token, parser->err);
    if (st == RMAP_OK && parser->reference && parser->token.begin >= parser->definition_end)
        parser->token.kind = RMAP_TOKEN_END;
    return st;
}

bool rmap_parser_at_word(const struct rmap_parser *parser, const char *word)
{
    return rmap_token_is(parser->text, &parser->token, word);
}

enum rmap_status rmap_parser_expected(const struct rmap_parser *parser, const char *what)
{
    const struct rmap_token *token = &parser->token;
    if (token->kind == RMAP_TOKEN_END)
        return RMAP_PARSER_FAIL(parser, token, "expected %s, found the end", what);
    char shown[RMAP_SHOWN_NBYTES];
    rmap_token_shorten(parser->text, token, shown);
    return RMAP_PARSER_FAIL(parser, token, "expected %s, found %s%s%s", what,
                            *shown == '\'' ? "" : "'", shown, *shown == '\'' ? "" : "'");
}

enum rmap_status rmap_parser_take(struct rmap_parser *parser, enum rmap_token_kind kind,
                                  const char *what)
{
    return parser->token.kind == kind ? rmap_parser_advance(parser)
                                      : rmap_parser_expected(parser, what);
}

static struct rmap_criterion_node *node_at(const struct rmap_parser *parser, int32_t index)
{
    return &parser->criterion->node[index];
}

/* A node of this kind over the text of its first child. */
static enum rmap_status add_parent(struct rmap_parser *parser, enum rmap_criterion_kind kind,
                                   int32_t child, int32_t *node_ret)
{
    struct rmap_criterion_node node = {.kind = kind,
                                       .first = child,
                                       .next = -1,
                                       .begin = node_at(parser, child)->begin,
                                       .end = node_at(parser, child)->end};
    return rmap_criterion_node_add(parser->criterion, &node, node_ret, parser->err);
}

static enum rmap_status parse_parentheses(struct rmap_parser *parser, int32_t *node_ret)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_token open = parser->token;
    if (++parser->depth > RMAP_CRITERION_DEPTH)
        return RMAP_PARSER_FAIL(parser, &open, "more than %d nested parentheses",
                                RMAP_CRITERION_DEPTH);
    RMAP_TRY(rmap_parser_advance(parser));
    RMAP_TRY(rmap_parse_logic(parser, node_ret));
    if (parser->token.kind == RMAP_TOKEN_END)
        return RMAP_PARSER_FAIL(parser, &open, "this parenthesis is never closed");
    RMAP_TRY(rmap_parser_take(parser, RMAP_TOKEN_CLOSE, "'and', 'or' or ')'"));
    parser->depth--;
    if (rmap_parser_at_comparison(parser))
        st = RMAP_PARSER_FAIL(parser, &parser->token,
                              "only a single test can be counted, not an expression");
out:
    return st;
}

static enum rmap_status parse_not(struct rmap_parser *parser, int32_t *node_ret)
{
    enum rmap_status st = RMAP_OK;
    size_t begin = parser->token.begin;
    bool negate = false;
    while (parser->token.kind == RMAP_TOKEN_NOT) {
        negate = !negate;
        RMAP_TRY(rmap_parser_advance(parser));
    }
    int32_t child = -1;
    if (parser->token.kind == RMAP_TOKEN_OPEN)
        RMAP_TRY(parse_parentheses(parser, &child));
    else
        RMAP_TRY(rmap_parse_test(parser, &child));
    *node_ret = child;
    if (negate) {
        RMAP_TRY(add_parent(parser, RMAP_CRITERION_NOT, child, node_ret));
        node_at(parser, *node_ret)->begin = begin;
    }
out:
    return st;
}

/* A chain of `part` joined by one operator; a chain of one is that one. */
static enum rmap_status parse_chain(struct rmap_parser *parser, enum rmap_token_kind joint,
                                    enum rmap_criterion_kind kind,
                                    enum rmap_status (*part)(struct rmap_parser *, int32_t *),
                                    int32_t *node_ret)
{
    enum rmap_status st = RMAP_OK;
    int32_t last = -1, next = -1;
    RMAP_TRY(part(parser, &last));
    *node_ret = last;
    if (parser->token.kind != joint)
        goto out;
    RMAP_TRY(add_parent(parser, kind, last, node_ret));
    while (parser->token.kind == joint) {
        RMAP_TRY(rmap_parser_advance(parser));
        RMAP_TRY(part(parser, &next));
        node_at(parser, last)->next = next;
        node_at(parser, *node_ret)->end = node_at(parser, next)->end;
        last = next;
    }
out:
    return st;
}

static enum rmap_status parse_and(struct rmap_parser *parser, int32_t *node_ret)
{
    return parse_chain(parser, RMAP_TOKEN_AND, RMAP_CRITERION_AND, parse_not, node_ret);
}

enum rmap_status rmap_parse_logic(struct rmap_parser *parser, int32_t *node_ret)
{
    return parse_chain(parser, RMAP_TOKEN_OR, RMAP_CRITERION_OR, parse_and, node_ret);
}

/* The whole text; detector NULL: the whole language. */
static enum rmap_status parse(struct rmap_criterion *criterion,
                              const struct rmap_criteria *criteria,
                              const struct rmap_index_set *detector, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_criterion_node node;
    struct rmap_parser parser = {
        .criterion = criterion, .text = criterion->text, .criteria = criteria, .err = err};
    RMAP_TRY(rmap_criterion_check_utf8(parser.text, err));
    RMAP_TRY(rmap_names_create(criterion->scene, &parser.names, err));
    RMAP_TRY(rmap_parser_advance(&parser));
    if (detector) {
        RMAP_TRY(rmap_parse_which(&parser, detector, &node));
        st = rmap_criterion_node_add(criterion, &node, &criterion->root, err);
        goto out;
    }
    if (parser.token.kind == RMAP_TOKEN_END) {
        st = RMAP_PARSER_FAIL(&parser, &parser.token,
                              "the criterion is empty (all rays: write 'all')");
        goto out;
    }
    RMAP_TRY(rmap_parse_logic(&parser, &criterion->root));
    if (parser.token.kind != RMAP_TOKEN_END)
        st = rmap_parser_expected(&parser, "'and', 'or' or the end");
out:
    rmap_names_destroy(parser.names);
    return st;
}

enum rmap_status rmap_criterion_parse(struct rmap_criterion *criterion,
                                      const struct rmap_criteria *criteria, struct rmap_error *err)
{
    return parse(criterion, criteria, NULL, err);
}

enum rmap_status rmap_criterion_parse_which(struct rmap_criterion *criterion,
                                            const struct rmap_criteria *criteria,
                                            const struct rmap_index_set *detector,
                                            struct rmap_error *err)
{
    return parse(criterion, criteria, detector, err);
}
