/* SPDX-License-Identifier: MIT
 *
 * Words of a criterion text, and the message that points at one of them.
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/criterion/criterion_lex.h"

/* Messages that point into a criterion's text. */

/* Code points of a line that are shown: a terminal's width, and within the error's room even
 * when each takes four bytes. */
enum { SHOWN = 96, SHOWN_BEFORE = 60 };

/* Bytes of the code point at s; 0 when it is not UTF-8 (overlong, surrogate or beyond U+10FFFF
 * included). */
static size_t code_point_nbytes(const char *s)
{
    static const struct {
        uint8_t lead_mask, lead;
        uint32_t least;
    } form[] = {{0x80, 0x00, 0}, {0xe0, 0xc0, 0x80}, {0xf0, 0xe0, 0x800}, {0xf8, 0xf0, 0x10000}};
    const unsigned char *byte = (const unsigned char *)s;
    for (size_t n = 1; n <= 4; n++) {
        if ((byte[0] & form[n - 1].lead_mask) != form[n - 1].lead)
            continue;
        uint32_t value = byte[0] & (uint8_t)~form[n - 1].lead_mask;
        for (size_t i = 1; i < n; i++) {
            if ((byte[i] & 0xc0) != 0x80)
                return 0;
            value = value << 6 | (byte[i] & 0x3f);
        }
        bool surrogate = value >= 0xd800 && value <= 0xdfff;
        return value < form[n - 1].least || value > 0x10ffff || surrogate ? 0 : n;
    }
    return 0;
}

enum rmap_status rmap_criterion_check_utf8(const char *text, struct rmap_error *err)
{
    for (size_t at = 0; text[at];) {
        size_t nbytes = code_point_nbytes(text + at);
        if (!nbytes)
            return rmap_criterion_fail(text, at, at + 1, err, "this is not UTF-8 text");
        at += nbytes;
    }
    return RMAP_OK;
}

void rmap_criterion_shorten(const char *word, char shown[RMAP_SHOWN_NBYTES])
{
    enum { ROOM = RMAP_SHOWN_NBYTES - 4 };
    size_t len = strlen(word);
    const char *dots = len > ROOM ? "..." : "";
    if (len > ROOM)
        for (len = ROOM; len > 0 && ((unsigned char)word[len] & 0xc0) == 0x80;)
            len--;
    (void)snprintf(shown, RMAP_SHOWN_NBYTES, "%.*s%s", (int)len, word, dots);
}

void rmap_token_shorten(const char *text, const struct rmap_token *token,
                        char shown[RMAP_SHOWN_NBYTES])
{
    char written[RMAP_SHOWN_NBYTES + 8];
    size_t len = token->end - token->begin;
    if (len > sizeof written - 1)
        len = sizeof written - 1;
    memcpy(written, text + token->begin, len);
    written[len] = 0;
    written[strcspn(written, "\r\n")] = 0;
    rmap_criterion_shorten(written, shown);
}

/* Where a line stands, and what of it is shown: code points [first, last), from 0. */
struct view {
    const char *line;
    size_t nbytes;
    size_t first, last, n_code_point;
    size_t mark, n_mark; /* code points under the caret and its tail */
};

static size_t step_nbytes(const char *s)
{
    size_t nbytes = code_point_nbytes(s);
    return nbytes ? nbytes : 1;
}

static size_t count_code_points(const char *s, size_t nbytes)
{
    size_t n = 0;
    for (size_t at = 0; at < nbytes; at += step_nbytes(s + at))
        n++;
    return n;
}

static struct view view_of(const char *text, size_t begin, size_t end)
{
    size_t from = begin;
    while (from > 0 && text[from - 1] != '\n')
        from--;
    struct view view = {.line = text + from, .nbytes = strcspn(text + from, "\r\n")};
    if (end > from + view.nbytes)
        end = from + view.nbytes;
    view.n_code_point = count_code_points(view.line, view.nbytes);
    view.mark = count_code_points(view.line, begin - from);
    view.n_mark = end > begin ? count_code_points(text + begin, end - begin) : 1;
    if (view.n_code_point > SHOWN && view.mark > SHOWN_BEFORE)
        view.first = view.mark - SHOWN_BEFORE;
    view.last = view.n_code_point;
    if (view.last > view.first + SHOWN)
        view.last = view.first + SHOWN;
    if (view.n_mark > 1 && view.mark + view.n_mark > view.last)
        view.n_mark = view.last > view.mark ? view.last - view.mark : 1;
    return view;
}

struct out {
    char *text;
    size_t len, cap;
};

static void put(struct out *out, const char *bytes, size_t nbytes)
{
    if (nbytes >= out->cap - out->len)
        return;
    memcpy(out->text + out->len, bytes, nbytes);
    out->len += nbytes;
    out->text[out->len] = 0;
}

static void put_line(struct out *out, const struct view *view)
{
    put(out, "\n  ", 3);
    if (view->first > 0)
        put(out, "...", 3);
    size_t index = 0;
    for (size_t at = 0; at < view->nbytes && index < view->last; index++) {
        const char *c = view->line + at;
        size_t nbytes = step_nbytes(c);
        at += nbytes;
        if (index < view->first)
            continue;
        bool odd =
            nbytes == 1 && (((unsigned char)*c < ' ' && *c != '\t') || (unsigned char)*c >= 0x7f);
        put(out, odd ? "?" : c, nbytes);
    }
    if (view->last < view->n_code_point)
        put(out, "...", 3);
}

static void put_caret(struct out *out, const struct view *view)
{
    put(out, "\n  ", 3);
    if (view->first > 0)
        put(out, "   ", 3);
    size_t index = 0;
    for (size_t at = 0; at < view->nbytes && index < view->mark; index++) {
        if (index >= view->first)
            put(out, view->line[at] == '\t' ? "\t" : " ", 1);
        at += step_nbytes(view->line + at);
    }
    put(out, "^", 1);
    for (size_t i = 1; i < view->n_mark; i++)
        put(out, "~", 1);
}

enum rmap_status rmap_criterion_fail(const char *text, size_t begin, size_t end,
                                     struct rmap_error *err, const char *format, ...)
{
    if (!err)
        return RMAP_INPUT;
    char message[384];
    va_list args;
    va_start(args, format);
    (void)vsnprintf(message, sizeof message, format, args);
    va_end(args);
    size_t line = 1;
    for (size_t i = 0; i < begin; i++)
        line += text[i] == '\n';
    struct view view = view_of(text, begin, end);
    (void)rmap_error_set(err, RMAP_INPUT, "criterion:%zu:%zu: error: %s", line, view.mark + 1,
                         message);
    struct out out = {err->text, strlen(err->text), sizeof err->text};
    put_line(&out, &view);
    put_caret(&out, &view);
    return RMAP_INPUT;
}

void rmap_criterion_relabel(const char *label, struct rmap_error *err)
{
    static const char prefix[] = "criterion:";
    if (!err || strncmp(err->text, prefix, strlen(prefix)) != 0)
        return;
    size_t n_old = strlen(prefix) - 1, n_new = strlen(label), n_rest = strlen(err->text) - n_old;
    if (n_new + n_rest >= sizeof err->text)
        return; /* a label that leaves no room for the message */
    memmove(err->text + n_new, err->text + n_old, n_rest + 1);
    memcpy(err->text, label, n_new);
}

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
        {"@", RMAP_TOKEN_AT},     {"+", RMAP_TOKEN_PLUS},  {"-", RMAP_TOKEN_MINUS},
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

/* A sign between letters may be one of a name, and is none of the language. */
static bool is_in_word(const char *text, size_t at)
{
    return at > 0 && continues_word(text[at - 1]) && continues_word(text[at + 1]);
}

static enum rmap_status fail_character(const char *text, size_t at, struct rmap_error *err)
{
    char c = text[at];
    if (c == '=')
        return rmap_criterion_fail(text, at, at + 1, err,
                                   "unexpected '=' (equality is written '==')");
    if (c == '/')
        return rmap_criterion_fail(
            text, at, at + 1, err,
            "unexpected character '/' (factors are written: 0.5 * path_length)");
    if (c <= ' ' || c >= 0x7f)
        return rmap_criterion_fail(text, at, at + 1, err, "unexpected character with code %d",
                                   (unsigned char)c);
    return rmap_criterion_fail(
        text, at, at + 1, err, "unexpected character '%c'%s", c,
        is_in_word(text, at) ? " (a name with such signs stands in single quotes)" : "");
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
    else if (((c == '+' || c == '-') && is_in_word(text, begin)) || !read_sign(text, &token))
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
