/* SPDX-License-Identifier: MIT
 *
 * A test of the criterion language as a number: how often it holds along a ray.
 */
#include "analysis/query/quantity_count.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"

static enum rmap_status fail_unless_count(const struct rmap_criterion *criterion,
                                          struct rmap_error *err)
{
    const struct rmap_criterion_node *node = &criterion->node[criterion->root];
    const bool counts = node->kind == RMAP_CRITERION_STEPS ||
                        node->kind == RMAP_CRITERION_REGISTRATIONS ||
                        node->kind == RMAP_CRITERION_SOURCE || node->kind == RMAP_CRITERION_ENDED ||
                        node->kind == RMAP_CRITERION_PATH;
    if (counts)
        return RMAP_OK;
    return rmap_criterion_fail(criterion->text, node->begin, node->end, err,
                               "expected one number or one test that counts, such as hit(NAME)");
}

/* A comparison behind the test would not be heeded. The test is known to be a good one. */
static enum rmap_status fail_unless_end_of_call(struct rmap_parser *parser)
{
    enum rmap_status st = RMAP_OK;
    int depth = 0;
    while (parser->token.kind != RMAP_TOKEN_OPEN && parser->token.kind != RMAP_TOKEN_END)
        RMAP_TRY(rmap_parser_advance(parser));
    do {
        depth += parser->token.kind == RMAP_TOKEN_OPEN;
        depth -= parser->token.kind == RMAP_TOKEN_CLOSE;
        if (parser->token.kind != RMAP_TOKEN_END)
            RMAP_TRY(rmap_parser_advance(parser));
    } while (depth > 0 && parser->token.kind != RMAP_TOKEN_END);
    if (parser->token.kind != RMAP_TOKEN_END)
        st = rmap_parser_expected(parser, "the end (comparisons go to --where)");
out:
    return st;
}

enum rmap_status rmap_quantity_parse_count(struct rmap_parser *parser,
                                           const struct rmap_scene *scene, const char *counts,
                                           struct rmap_criterion **counted_ret)
{
    enum rmap_status st = RMAP_OK;
    char *written = NULL;
    const char *text = parser->text;
    if (counts) {
        RMAP_TRY(rmap_parser_advance(parser));
        text = counts;
    }
    if (counts && parser->token.kind == RMAP_TOKEN_OPEN && strncmp(text, "registered", 10) == 0) {
        size_t nbytes = strlen(parser->text) + 16;
        written = rmap_alloc(nbytes, 1);
        if (!written)
            return rmap_error_set(parser->err, RMAP_SYSTEM, "out of memory for --of");
        (void)snprintf(written, nbytes, "registered%s", parser->text + parser->token.begin);
        text = written;
    } else if (counts && parser->token.kind != RMAP_TOKEN_END) {
        return rmap_parser_expected(parser, "the end");
    }
    RMAP_TRY(rmap_criterion_compile(text, scene, counted_ret, parser->err));
    RMAP_TRY(fail_unless_count(*counted_ret, parser->err));
    RMAP_TRY(fail_unless_end_of_call(parser));
out:
    rmap_free(written);
    return st;
}
