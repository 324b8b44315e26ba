/* SPDX-License-Identifier: MIT
 *
 * @NAME: the definition's text is parsed where it is used, so that its tests become part of the
 * tree like any others. Definitions may use each other in any order, but not themselves. A name
 * that has no definition may be that of rays which the map keeps.
 */
#include <stdio.h>
#include <string.h>

#include "analysis/criterion/criterion_file_internal.h"
#include "analysis/criterion/criterion_parser.h"
#include "analysis/criterion/criterion_value.h"
#include "analysis/criterion/criterion_word.h"
#include "base/alloc.h"
#include "io/file/diagnostics.h"

/* Definitions used in definitions multiply. */
enum { NODE_MAX = 100000, SPELLED_MAX = 65536 };

/* Open definitions, the innermost first. */
struct rmap_reference {
    size_t let;
    const struct rmap_reference *outer;
};

static enum rmap_status fail_unknown(const struct rmap_parser *parser,
                                     const struct rmap_token *token, const char *name)
{
    const struct rmap_criteria *criteria = parser->criteria;
    const struct rmap_ray_names *names = parser->criterion->scene->ray_names;
    char shown[RMAP_SHOWN_NBYTES];
    rmap_criterion_shorten(name, shown);
    const size_t n = criteria ? criteria->n : 0;
    const char **known = rmap_alloc(n + 1, sizeof *known);
    for (size_t i = 0; known && i < n; i++)
        known[i] = criteria->let[i].name;
    const char *near = known ? rmap_nearest_word(name, known, n) : NULL;
    char *kept = names && !near ? names->near(names->context, name) : NULL;
    near = near ? near : kept;
    char hint[RMAP_SHOWN_NBYTES + 32] = "";
    if (near)
        (void)snprintf(hint, sizeof hint, " (did you mean '%s'?)", near);
    rmap_free(known);
    rmap_free(kept);
    if (!criteria)
        return RMAP_PARSER_FAIL(parser, token,
                                "no criterion is named '%s'%s: --criteria FILE defines names, as "
                                "let %s = ..., and raymap select keeps rays in the map by name",
                                shown, hint, shown);
    if (strcmp(criteria->label, RMAP_CRITERION_LABEL) == 0) /* lines, not a file */
        return RMAP_PARSER_FAIL(parser, token, "no criterion is named '%s' so far%s", shown, hint);
    return RMAP_PARSER_FAIL(parser, token, "no criterion is named '%s' in %.64s%s", shown,
                            criteria->label, hint);
}

/* Rays of the map that have the name; *rays NULL: none. */
static enum rmap_status find_rays(struct rmap_parser *parser, const struct rmap_token *token,
                                  const char *name, bool is_defined,
                                  const struct rmap_id_set **rays)
{
    struct rmap_error why = {0};
    const struct rmap_ray_names *names = parser->criterion->scene->ray_names;
    *rays = NULL;
    enum rmap_status st = names ? names->find(names->context, name, rays, &why) : RMAP_OK;
    if (is_defined && (*rays || st != RMAP_OK))
        return RMAP_PARSER_FAIL(parser, token,
                                "'%s' is defined in %.64s, and rays of the map are named so: give "
                                "one another name",
                                name, parser->criteria->label);
    if (st == RMAP_SYSTEM || st == RMAP_FORMAT)
        return rmap_error_set(parser->err, st, "%s", why.text);
    return st == RMAP_OK ? RMAP_OK : RMAP_PARSER_FAIL(parser, token, "%s", why.text);
}

/* The name behind '@': which definition it is; or else rays, not NULL. */
RMAP_OWN_FRAME static enum rmap_status find_name(struct rmap_parser *parser,
                                                 struct rmap_token *token, size_t *let,
                                                 const struct rmap_id_set **rays)
{
    enum rmap_status st = RMAP_OK;
    char name[RMAP_TOKEN_NAME_NBYTES + 1], shown[RMAP_SHOWN_NBYTES];
    RMAP_TRY(rmap_parser_advance(parser));
    RMAP_TRY(rmap_parser_take_name(parser, "the name of a criterion", token));
    rmap_token_name(parser->text, token, name);
    *let = parser->criteria ? rmap_criteria_find(parser->criteria, name) : SIZE_MAX;
    RMAP_TRY(find_rays(parser, token, name, *let != SIZE_MAX, rays));
    if (*let == SIZE_MAX && !*rays)
        return fail_unknown(parser, token, name);
    for (const struct rmap_reference *open = parser->reference; open; open = open->outer)
        if (!*rays && open->let == *let) {
            rmap_criterion_shorten(name, shown);
            return RMAP_PARSER_FAIL(parser, token, "'%s' is defined by itself", shown);
        }
    if (rmap_parser_at_comparison(parser))
        st = RMAP_PARSER_FAIL(parser, &parser->token,
                              "only a single test can be counted, not a named criterion");
out:
    return st;
}

/* Parses the definition with the same parser: what it was about to read comes back afterwards. */
static enum rmap_status parse_definition(struct rmap_parser *parser, size_t index,
                                         int32_t *node_ret)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_let *let = &parser->criteria->let[index];
    const struct rmap_parser outer = *parser;
    struct rmap_reference reference = {index, outer.reference};
    parser->text = parser->criteria->text;
    parser->reference = &reference;
    parser->definition_end = let->end;
    parser->token = (struct rmap_token){.end = let->begin};
    RMAP_TRY(rmap_parser_advance(parser));
    RMAP_TRY(rmap_parse_logic(parser, node_ret));
    if (parser->token.kind != RMAP_TOKEN_END)
        st = rmap_parser_expected(parser, "'and', 'or' or the end of the definition");
out:
    if (st == RMAP_INPUT)
        rmap_criterion_relabel(outer.criteria->label, outer.err);
    parser->text = outer.text;
    parser->reference = outer.reference;
    parser->definition_end = outer.definition_end;
    parser->token = outer.token;
    parser->taken_end = outer.taken_end;
    parser->word = outer.word;
    return st;
}

enum rmap_status rmap_parse_reference(struct rmap_parser *parser, int32_t *node_ret)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_criterion *criterion = parser->criterion;
    struct rmap_token at = parser->token, name = at;
    const struct rmap_id_set *rays = NULL;
    size_t first = criterion->n_node, let = 0;
    RMAP_TRY(find_name(parser, &name, &let, &rays));
    if (rays) {
        const struct rmap_criterion_node node = {.kind = RMAP_CRITERION_RAYS,
                                                 .first = -1,
                                                 .next = -1,
                                                 .begin = at.begin,
                                                 .end = name.end,
                                                 .rays = rays};
        return rmap_criterion_node_add(criterion, &node, node_ret, parser->err);
    }
    if (++parser->depth > RMAP_CRITERION_DEPTH)
        return RMAP_PARSER_FAIL(parser, &name, "definitions stand in definitions more than %d deep",
                                RMAP_CRITERION_DEPTH);
    RMAP_TRY(parse_definition(parser, let, node_ret));
    parser->depth--;
    if (criterion->n_node > NODE_MAX)
        return RMAP_PARSER_FAIL(parser, &name,
                                "with all its definitions the criterion has more than %d tests",
                                NODE_MAX);
    for (size_t i = first; i < criterion->n_node; i++) {
        criterion->node[i].begin = at.begin;
        criterion->node[i].end = name.end;
    }
out:
    return st;
}

/* ---- without names ---- */

struct spelling {
    const struct rmap_criteria *criteria;
    const struct rmap_ray_names *names;
    char *text; /* [SPELLED_MAX] */
    size_t len;
    bool is_full;
};

static void put(struct spelling *self, const char *text, size_t n)
{
    self->is_full = self->is_full || n >= SPELLED_MAX - self->len;
    if (self->is_full)
        return;
    memcpy(self->text + self->len, text, n);
    self->len += n;
}

/* Whether its parts would come apart beside others. */
static bool is_joined(const char *text)
{
    struct rmap_token token = {.end = 0};
    do {
        if (rmap_token_read(text, token.end, &token, NULL) != RMAP_OK)
            return true;
    } while (token.kind != RMAP_TOKEN_END && token.kind != RMAP_TOKEN_AND &&
             token.kind != RMAP_TOKEN_OR);
    return token.kind != RMAP_TOKEN_END;
}

static void spell(struct spelling *self, const char *text)
{
    struct rmap_token token = {.end = 0}, behind;
    size_t done = 0;
    while (rmap_token_read(text, token.end, &token, NULL) == RMAP_OK &&
           token.kind != RMAP_TOKEN_END && !self->is_full) {
        char name[RMAP_TOKEN_NAME_NBYTES + 1];
        const size_t at = token.begin;
        if (token.kind != RMAP_TOKEN_AT ||
            rmap_token_read(text, token.end, &token, NULL) != RMAP_OK)
            continue;
        rmap_token_name(text, &token, name);
        const size_t let = self->criteria ? rmap_criteria_find(self->criteria, name) : SIZE_MAX;
        const char *words = let != SIZE_MAX ? self->criteria->let[let].definition
                            : self->names   ? self->names->words(self->names->context, name)
                                            : NULL;
        if (!words)
            continue;
        const bool is_all = at == strspn(text, " \t\r\n") &&
                            rmap_token_read(text, token.end, &behind, NULL) == RMAP_OK &&
                            behind.kind == RMAP_TOKEN_END;
        const bool is_apart = !is_all && is_joined(words);
        put(self, text + done, at - done);
        put(self, "(", is_apart);
        if (let != SIZE_MAX)
            spell(self, words);
        else
            put(self, words, strlen(words));
        put(self, ")", is_apart);
        done = token.end;
    }
    put(self, text + done, strlen(text + done));
}

enum rmap_status rmap_criterion_spell(const struct rmap_criterion *criterion,
                                      const struct rmap_criteria *criteria, char **text_ret,
                                      struct rmap_error *err)
{
    struct spelling self = {.criteria = criteria,
                            .names = criterion->scene->ray_names,
                            .text = rmap_alloc(SPELLED_MAX, 1)};
    if (self.text)
        spell(&self, criterion->text);
    *text_ret = self.text && !self.is_full ? rmap_strdup(self.text) : rmap_strdup(criterion->text);
    rmap_free(self.text);
    return *text_ret ? RMAP_OK : rmap_error_set(err, RMAP_SYSTEM, "out of memory for a criterion");
}
