/* SPDX-License-Identifier: MIT
 *
 * Text to tokens.
 */
#include "analysis/criterion/criterion_lex.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* Bytes beyond ASCII belong to words: the text is checked UTF-8. */
static bool begins_word(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '*' || c == '?' ||
           (unsigned char)c >= 0x80;
}

static bool continues_word(char c)
{
    return begins_word(c) || is_digit(c) || c == '.';
}

static bool begins_number(const char *s)
{
    if (*s == '-' || *s == '+')
        s++;
    return is_digit(s[0]) || (s[0] == '.' && is_digit(s[1]));
}

/* Length of a number's text. "2..4" is 2, then a range. */
static size_t number_nbytes(const char *s)
{
    const char *p = s;
    if (*p == '-' || *p == '+')
        p++;
    while (is_digit(*p))
        p++;
    if (p[0] == '.' && p[1] != '.') {
        p++;
        while (is_digit(*p))
            p++;
    }
    if (*p == 'e' || *p == 'E') {
        const char *exponent = p + 1;
        if (*exponent == '-' || *exponent == '+')
            exponent++;
        if (is_digit(*exponent)) {
            while (is_digit(*exponent))
                exponent++;
            p = exponent;
        }
    }
    return (size_t)(p - s);
}

static enum rmap_status read_number(const char *text, struct rmap_token *token,
                                    struct rmap_error *err)
{
    char copy[64];
    size_t nbytes = number_nbytes(text + token->begin);
    token->kind = RMAP_TOKEN_NUMBER;
    token->end = token->begin + nbytes;
    if (nbytes >= sizeof copy)
        return rmap_criterion_fail(text, token->begin, token->end, err,
                                   "a number of %zu characters is too long", nbytes);
    memcpy(copy, text + token->begin, nbytes);
    copy[nbytes] = 0;
    token->number = strtod(copy, NULL);
    if (!isfinite(token->number))
        return rmap_criterion_fail(text, token->begin, token->end, err, "the number is too large");
    return RMAP_OK;
}

static enum rmap_status check_name_nbytes(const char *text, const struct rmap_token *token,
                                          struct rmap_error *err)
{
    size_t nbytes = token->end - token->begin;
    if (nbytes <= RMAP_TOKEN_NAME_NBYTES)
        return RMAP_OK;
    return rmap_criterion_fail(text, token->begin, token->end, err,
                               "a word of %zu bytes is too long for a name", nbytes);
}

static enum rmap_status read_word(const char *text, struct rmap_token *token,
                                  struct rmap_error *err)
{
    static const struct {
        const char *word;
        enum rmap_token_kind kind;
    } logic[] = {{"not", RMAP_TOKEN_NOT}, {"and", RMAP_TOKEN_AND}, {"or", RMAP_TOKEN_OR}};
    token->kind = RMAP_TOKEN_WORD;
    token->end = token->begin + 1;
    while (continues_word(text[token->end]) && strncmp(text + token->end, "..", 2) != 0)
        token->end++;
    size_t nbytes = token->end - token->begin;
    for (size_t i = 0; i < sizeof logic / sizeof *logic; i++)
        if (strlen(logic[i].word) == nbytes &&
            memcmp(logic[i].word, text + token->begin, nbytes) == 0)
            token->kind = logic[i].kind;
    return check_name_nbytes(text, token, err);
}

static enum rmap_status read_quoted(const char *text, struct rmap_token *token,
                                    struct rmap_error *err)
{
    char quote = text[token->begin];
    token->kind = quote == '"' ? RMAP_TOKEN_STRING : RMAP_TOKEN_QUOTED;
    size_t at = token->begin + 1;
    while (text[at] && (text[at] != quote || (quote == '\'' && text[at + 1] == quote)))
        at += text[at] == quote ? 2 : 1;
    if (!text[at])
        return rmap_criterion_fail(text, token->begin, token->begin + 1, err,
                                   "this quote is never closed");
    token->end = at + 1;
    return quote == '"' ? RMAP_OK : check_name_nbytes(text, token, err);
}

static bool read_sign(const char *text, struct rmap_token *token)
{
    static const struct {
        const char *sign;
        enum rmap_token_kind kind;
    } table[] = {
        {"..", RMAP_TOKEN_RANGE}, {"==", RMAP_TOKEN_EQ},   {"!=", RMAP_TOKEN_NE},
        {"<=", RMAP_TOKEN_LE},    {">=", RMAP_TOKEN_GE},   {"&&", RMAP_TOKEN_AND},
        {"||", RMAP_TOKEN_OR},    {"<", RMAP_TOKEN_LT},    {">", RMAP_TOKEN_GT},
        {"!", RMAP_TOKEN_NOT},    {"&", RMAP_TOKEN_AND},   {"|", RMAP_TOKEN_OR},
        {"(", RMAP_TOKEN_OPEN},   {")", RMAP_TOKEN_CLOSE}, {",", RMAP_TOKEN_COMMA},
        {"@", RMAP_TOKEN_AT},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        size_t nbytes = strlen(table[i].sign);
        if (strncmp(text + token->begin, table[i].sign, nbytes) == 0) {
            token->kind = table[i].kind;
            token->end = token->begin + nbytes;
            return true;
        }
    }
    return false;
}

static enum rmap_status fail_character(const char *text, size_t at, struct rmap_error *err)
{
    char c = text[at];
    if (c == '=')
        return rmap_criterion_fail(text, at, at + 1, err,
                                   "unexpected '=' (equality is written '==')");
    if (c <= ' ' || c >= 0x7f)
        return rmap_criterion_fail(text, at, at + 1, err, "unexpected character with code %d",
                                   (unsigned char)c);
    bool in_word = at > 0 && continues_word(text[at - 1]) && continues_word(text[at + 1]);
    return rmap_criterion_fail(text, at, at + 1, err, "unexpected character '%c'%s", c,
                               in_word ? " (a name with such signs stands in single quotes)" : "");
}

enum rmap_status rmap_token_read(const char *text, size_t begin, struct rmap_token *token_ret,
                                 struct rmap_error *err)
{
    begin += strspn(text + begin, " \t\r\n");
    struct rmap_token token = {.begin = begin, .end = begin};
    enum rmap_status st = RMAP_OK;
    char c = text[begin];
    if (!c)
        token.kind = RMAP_TOKEN_END;
    else if (begins_number(text + begin))
        st = read_number(text, &token, err);
    else if (begins_word(c))
        st = read_word(text, &token, err);
    else if (c == '\'' || c == '"')
        st = read_quoted(text, &token, err);
    else if (!read_sign(text, &token))
        st = fail_character(text, begin, err);
    if (st == RMAP_OK)
        *token_ret = token;
    return st;
}

bool rmap_token_is(const char *text, const struct rmap_token *token, const char *word)
{
    size_t len = strlen(word);
    return token->kind == RMAP_TOKEN_WORD && token->end - token->begin == len &&
           memcmp(text + token->begin, word, len) == 0;
}

void rmap_criterion_blank_comments(char *text)
{
    char quote = 0;
    for (char *c = text; *c; c++) {
        if (quote) {
            quote = *c == quote ? 0 : quote;
        } else if (*c == '\'' || *c == '"') {
            quote = *c;
        } else if (*c == '#') {
            while (*c && *c != '\n')
                *c++ = ' ';
            if (!*c)
                return;
        }
    }
}
