/* SPDX-License-Identifier: MIT
 *
 * Named criteria: a text of `let NAME = CRITERION`, one after another, used as @NAME. A '#' begins
 * a comment up to the line's end.
 */
#include "analysis/criterion/criterion_file.h"

#include <string.h>

#include "analysis/criterion/criterion_file_internal.h"
#include "analysis/criterion/criterion_lex.h"
#include "analysis/criterion/criterion_names.h"
#include "analysis/criterion/path_store.h"
#include "base/alloc.h"

static char *copy_bytes(const char *from, size_t nbytes)
{
    char *copy = rmap_alloc(nbytes + 1, 1);
    if (copy)
        memcpy(copy, from, nbytes);
    return copy;
}

/* Where a name stands among the slots, or the free one where it would. */
static size_t slot_of(const struct rmap_criteria *criteria, const char *name)
{
    uint64_t hash = 0xcbf29ce484222325u; /* FNV-1a */
    for (const char *c = name; *c; c++)
        hash = (hash ^ (unsigned char)*c) * 0x100000001b3u;
    size_t at = (size_t)(hash ^ hash >> 32) & (criteria->n_slot - 1);
    while (criteria->slot[at] && strcmp(criteria->let[criteria->slot[at] - 1].name, name) != 0)
        at = (at + 1) & (criteria->n_slot - 1);
    return at;
}

/* Half of the slots at least stay free. */
static enum rmap_status enter_name(struct rmap_criteria *criteria, struct rmap_error *err)
{
    if (2 * criteria->n > criteria->n_slot) {
        const size_t n_slot = criteria->n_slot ? 2 * criteria->n_slot : 16;
        size_t *slot = rmap_alloc(n_slot, sizeof *slot);
        if (!slot)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the criteria");
        rmap_free(criteria->slot);
        criteria->slot = slot;
        criteria->n_slot = n_slot;
        for (size_t i = 0; i + 1 < criteria->n; i++)
            slot[slot_of(criteria, criteria->let[i].name)] = i + 1;
    }
    criteria->slot[slot_of(criteria, criteria->let[criteria->n - 1].name)] = criteria->n;
    return RMAP_OK;
}

static enum rmap_status add_let(struct rmap_criteria *criteria, const struct rmap_token *token,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char name[RMAP_TOKEN_NAME_NBYTES + 1], shown[RMAP_SHOWN_NBYTES];
    rmap_token_name(criteria->text, token, name);
    if (token->kind == RMAP_TOKEN_WORD && strpbrk(name, "*?"))
        return rmap_criterion_fail(criteria->text, token->begin, token->end, err,
                                   "a name for a criterion has no wildcards");
    if (rmap_criteria_find(criteria, name) != SIZE_MAX) {
        rmap_criterion_shorten(name, shown);
        return rmap_criterion_fail(criteria->text, token->begin, token->end, err,
                                   "'%s' is defined already", shown);
    }
    RMAP_TRY(RMAP_RESERVE(criteria->let, criteria->cap, criteria->n + 1, err));
    struct rmap_let *let = &criteria->let[criteria->n];
    *let = (struct rmap_let){.name = rmap_strdup(name),
                             .reference = rmap_alloc(token->end - token->begin + 2, 1),
                             .name_begin = token->begin,
                             .name_end = token->end};
    criteria->n++;
    if (!let->name || !let->reference)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the criteria");
    let->reference[0] = '@';
    memcpy(let->reference + 1, criteria->text + token->begin, token->end - token->begin);
    st = enter_name(criteria, err);
out:
    return st;
}

/* NAME = , behind `let`; *token is the last one taken. */
static enum rmap_status read_head(struct rmap_criteria *criteria, struct rmap_token *token,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const char *text = criteria->text;
    RMAP_TRY(rmap_token_read(text, token->end, token, err));
    if (token->kind != RMAP_TOKEN_WORD && token->kind != RMAP_TOKEN_QUOTED)
        return rmap_criterion_fail(text, token->begin, token->end, err,
                                   "expected a name behind 'let', as in: let ghost = hit(lens)");
    RMAP_TRY(add_let(criteria, token, err));
    size_t equals = token->end + strspn(text + token->end, " \t\r\n");
    if (text[equals] != '=' || text[equals + 1] == '=')
        return rmap_criterion_fail(text, equals, equals + 1, err,
                                   "expected '=' behind the name of a criterion");
    token->end = equals + 1;
    criteria->let[criteria->n - 1].begin = equals + 1;
out:
    return st;
}

/* Up to the next `let` outside of parentheses, or the end. */
static enum rmap_status read_definition(struct rmap_criteria *criteria, struct rmap_token *token,
                                        struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const char *text = criteria->text;
    struct rmap_let *let = &criteria->let[criteria->n - 1];
    size_t depth = 0, last = let->begin;
    for (;;) {
        RMAP_TRY(rmap_token_read(text, token->end, token, err));
        if (token->kind == RMAP_TOKEN_END || (depth == 0 && rmap_token_is(text, token, "let")))
            break;
        if (token->kind == RMAP_TOKEN_OPEN)
            depth++;
        else if (token->kind == RMAP_TOKEN_CLOSE && depth > 0)
            depth--;
        last = token->end;
    }
    let->end = token->begin;
    size_t begin = let->begin + strspn(text + let->begin, " \t\r\n");
    if (begin >= last)
        return rmap_criterion_fail(text, let->name_begin, let->name_end, err,
                                   "no criterion stands behind this name");
    let->definition = copy_bytes(text + begin, last - begin);
    if (!let->definition)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the criteria");
out:
    return st;
}

static enum rmap_status read_lets(struct rmap_criteria *criteria, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_token token = {0};
    const char *text = criteria->text;
    RMAP_TRY(rmap_criterion_check_utf8(text, err));
    RMAP_TRY(rmap_token_read(text, 0, &token, err));
    do {
        if (!rmap_token_is(text, &token, "let"))
            return rmap_criterion_fail(text, token.begin, token.end, err,
                                       "expected 'let NAME = CRITERION'");
        RMAP_TRY(read_head(criteria, &token, err));
        RMAP_TRY(read_definition(criteria, &token, err));
    } while (token.kind != RMAP_TOKEN_END);
out:
    return st;
}

enum rmap_status rmap_criteria_create(const char *text, const char *label,
                                      struct rmap_criteria **criteria_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_criteria *criteria = rmap_alloc(1, sizeof *criteria);
    if (criteria) { /* editors put a byte order mark at the front */
        criteria->text = rmap_strdup(text + (strncmp(text, "\xef\xbb\xbf", 3) == 0 ? 3 : 0));
        criteria->label = rmap_strdup(label);
        criteria->paths = rmap_path_store_create();
    }
    if (!criteria || !criteria->text || !criteria->label || !criteria->paths) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the criteria");
        goto out;
    }
    rmap_criterion_blank_comments(criteria->text);
    st = read_lets(criteria, err);
    if (st == RMAP_INPUT)
        rmap_criterion_relabel(criteria->label, err);
    RMAP_TRY(st);
    *criteria_ret = criteria;
    criteria = NULL;
out:
    rmap_criteria_destroy(criteria);
    return st;
}

void rmap_criteria_destroy(struct rmap_criteria *criteria)
{
    if (!criteria)
        return;
    for (size_t i = 0; i < criteria->n; i++) {
        rmap_free(criteria->let[i].name);
        rmap_free(criteria->let[i].definition);
        rmap_free(criteria->let[i].reference);
    }
    rmap_free(criteria->let);
    rmap_path_store_release(criteria->paths);
    rmap_free(criteria->slot);
    rmap_free(criteria->label);
    rmap_free(criteria->text);
    rmap_free(criteria);
}

size_t rmap_criteria_count(const struct rmap_criteria *criteria)
{
    return criteria->n;
}

const char *rmap_criteria_name(const struct rmap_criteria *criteria, size_t index)
{
    return criteria->let[index].name;
}

const char *rmap_criteria_definition(const struct rmap_criteria *criteria, size_t index)
{
    return criteria->let[index].definition;
}

const char *rmap_criteria_reference(const struct rmap_criteria *criteria, size_t index)
{
    return criteria->let[index].reference;
}

size_t rmap_criteria_find(const struct rmap_criteria *criteria, const char *name)
{
    if (criteria->n_slot == 0)
        return SIZE_MAX;
    const size_t found = criteria->slot[slot_of(criteria, name)];
    return found > 0 ? found - 1 : SIZE_MAX;
}
