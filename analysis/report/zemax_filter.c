/* SPDX-License-Identifier: MIT
 *
 * One pass, recursive descent: ! binds closest, then &, ^, |.
 */
#include "analysis/report/zemax_filter.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "analysis/report/zemax_flag.h"
#include "base/alloc.h"

enum { DEPTH_MAX = 500 };

static char peek(struct rmap_zemax_translation *t)
{
    t->at += strspn(t->text + t->at, " \t\r\n");
    return t->text[t->at];
}

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* Digits; any number beyond a scene's is one. */
static size_t read_number(struct rmap_zemax_translation *t)
{
    size_t number = 0;
    for (; is_digit(t->text[t->at]); t->at++)
        if (number < 1000000000)
            number = number * 10 + (size_t)(t->text[t->at] - '0');
    return number;
}

/* X_HITFACE(n, f): a face of a CAD object was hit; X_HIT(n, b): an object was, b times. */
static enum rmap_status read_extended(struct rmap_zemax_translation *t, size_t begin,
                                      struct rmap_zemax_draft *draft)
{
    static const struct {
        const char *word, *second;
        bool is_face;
    } known[] = {{"X_HITFACE(", "face", true}, {"X_HIT(", "times", false}};
    enum rmap_status st = RMAP_OK;
    struct rmap_zemax_flag flag = {.letter = 'X', .begin = begin};
    char number[32];
    size_t k = 0, n = sizeof known / sizeof *known;
    while (k < n && strncmp(t->text + begin, known[k].word, strlen(known[k].word)) != 0)
        k++;
    flag.end = begin + strcspn(t->text + begin, " \t\r\n&|^!)");
    if (k == n)
        return rmap_zemax_fail_unsupported(t, &flag);
    t->at = begin + strlen(known[k].word);
    flag.has_number = is_digit(peek(t));
    flag.number = read_number(t);
    bool comma = peek(t) == ',';
    t->at += comma;
    bool has_second = is_digit(peek(t));
    (void)snprintf(number, sizeof number, known[k].is_face ? "face %zu" : " == %zu",
                   read_number(t));
    if (!flag.has_number || !comma || !has_second || peek(t) != ')')
        return RMAP_ZEMAX_FAIL(t, begin, t->at, "expected %sobject, %s)", known[k].word,
                               known[k].second);
    t->at++;
    flag.end = t->at;
    RMAP_TRY(rmap_zemax_check_number(t, &flag, "object", t->scene->n_object));
    RMAP_TRY(rmap_zemax_put_hit(t, &flag, known[k].is_face ? number : NULL, draft));
    if (!known[k].is_face)
        st = rmap_zemax_put(t, draft, number);
out:
    return st;
}

static enum rmap_status read_flag(struct rmap_zemax_translation *t, struct rmap_zemax_draft *draft)
{
    char c = peek(t);
    size_t begin = t->at;
    if (!c)
        return RMAP_ZEMAX_FAIL(t, begin, begin, "expected a flag such as H3, found the end");
    bool lower = c >= 'a' && c <= 'z';
    struct rmap_zemax_flag flag = {.letter = lower ? (char)(c - 'a' + 'A') : c, .begin = begin};
    if (flag.letter < 'A' || flag.letter > 'Z')
        return RMAP_ZEMAX_FAIL(t, begin, begin + 1, "expected a flag such as H3, '!' or '('");
    if (strncmp(t->text + begin, "X_", 2) == 0)
        return read_extended(t, begin, draft);
    t->at++;
    flag.has_number = is_digit(t->text[t->at]);
    flag.number = read_number(t);
    flag.end = t->at;
    return rmap_zemax_put_flag(t, &flag, draft);
}

static enum rmap_status read_level(struct rmap_zemax_translation *t, int level,
                                   struct rmap_zemax_draft *draft);

static enum rmap_status read_not(struct rmap_zemax_translation *t, struct rmap_zemax_draft *draft)
{
    enum rmap_status st = RMAP_OK;
    bool negate = false;
    for (; peek(t) == '!'; t->at++)
        negate = !negate;
    if (negate)
        RMAP_TRY(rmap_zemax_put(t, draft, "not "));
    if (peek(t) != '(') {
        RMAP_TRY(read_flag(t, draft));
        return RMAP_OK;
    }
    size_t open = t->at++;
    if (++t->depth > DEPTH_MAX)
        return RMAP_ZEMAX_FAIL(t, open, open + 1, "more than %d nested parentheses", DEPTH_MAX);
    RMAP_TRY(rmap_zemax_put(t, draft, "("));
    RMAP_TRY(read_level(t, 0, draft));
    RMAP_TRY(rmap_zemax_put(t, draft, ")"));
    if (peek(t) != ')')
        return RMAP_ZEMAX_FAIL(t, open, open + 1, "this parenthesis is never closed");
    t->at++;
    t->depth--;
out:
    return st;
}

/* draft = (draft and not other) or (not draft and other), in parentheses */
static enum rmap_status put_either(struct rmap_zemax_translation *t, struct rmap_zemax_draft *draft,
                                   const struct rmap_zemax_draft *other)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_zemax_draft both = {0};
    RMAP_TRY(rmap_zemax_put_all(t, &both, "((", draft->text, ") and not (", other->text,
                                ") or not (", draft->text, ") and (", other->text, "))",
                                (char *)NULL));
    rmap_free(draft->text);
    *draft = both;
    both = (struct rmap_zemax_draft){0};
out:
    rmap_free(both.text);
    return st;
}

/* Levels 0, 1, 2: chains of |, ^ and &. */
static enum rmap_status read_level(struct rmap_zemax_translation *t, int level,
                                   struct rmap_zemax_draft *draft)
{
    static const char sign[] = "|^&";
    enum rmap_status st = RMAP_OK;
    struct rmap_zemax_draft own = {0}, next = {0};
    if (level == 3)
        return read_not(t, draft);
    RMAP_TRY(read_level(t, level + 1, &own));
    while (peek(t) == sign[level]) {
        t->at++;
        t->at += t->text[t->at] == sign[level]; /* && and || too */
        if (level != 1)
            RMAP_TRY(rmap_zemax_put(t, &own, level ? " and " : " or "));
        RMAP_TRY(read_level(t, level + 1, level == 1 ? &next : &own));
        if (level == 1)
            RMAP_TRY(put_either(t, &own, &next));
        next.nbytes = 0;
    }
    RMAP_TRY(rmap_zemax_put(t, draft, own.text));
out:
    rmap_free(next.text);
    rmap_free(own.text);
    return st;
}

enum rmap_status rmap_zemax_translate(const char *filter, const struct rmap_scene *scene,
                                      char **criterion_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_zemax_draft draft = {0};
    struct rmap_zemax_translation t = {.scene = scene, .text = filter, .err = err};
    RMAP_TRY(rmap_criterion_check_utf8(filter, err));
    if (!peek(&t)) {
        st = RMAP_ZEMAX_FAIL(&t, 0, 0, "the filter is empty");
        goto out;
    }
    RMAP_TRY(read_level(&t, 0, &draft));
    if (peek(&t)) {
        st = RMAP_ZEMAX_FAIL(&t, t.at, t.at + 1, "expected '&', '|', '^' or the end");
        goto out;
    }
    *criterion_ret = draft.text;
    draft.text = NULL;
out:
    if (st == RMAP_INPUT)
        rmap_criterion_relabel("zemax", err);
    rmap_free(draft.text);
    return st;
}
