/* SPDX-License-Identifier: MIT
 *
 * Words of a criterion text, and the message that points at one of them.
 */
#ifndef RMAP_CRITERION_LEX_H
#define RMAP_CRITERION_LEX_H

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

enum rmap_token_kind {
    RMAP_TOKEN_END,
    RMAP_TOKEN_WORD,   /* letters, digits, _ . and the wildcards * ?; not beginning with a digit */
    RMAP_TOKEN_QUOTED, /* 'odd name'; '' inside stands for one quote */
    RMAP_TOKEN_STRING, /* "..." */
    RMAP_TOKEN_NUMBER,
    RMAP_TOKEN_OPEN,
    RMAP_TOKEN_CLOSE,
    RMAP_TOKEN_COMMA,
    RMAP_TOKEN_RANGE, /* .. */
    RMAP_TOKEN_AT,
    RMAP_TOKEN_PLUS,
    RMAP_TOKEN_MINUS,
    RMAP_TOKEN_EQ,
    RMAP_TOKEN_NE,
    RMAP_TOKEN_LT,
    RMAP_TOKEN_LE,
    RMAP_TOKEN_GT,
    RMAP_TOKEN_GE,
    RMAP_TOKEN_NOT, /* also the words not, and, or */
    RMAP_TOKEN_AND,
    RMAP_TOKEN_OR
};

struct rmap_token {
    enum rmap_token_kind kind;
    size_t begin, end; /* bytes of the text */
    double number;     /* NUMBER, finite */
};

/* Longest name: keeps wildcard matching and messages within bounds. */
#define RMAP_TOKEN_NAME_NBYTES 512

/* The token at or after byte `begin` of the text. RMAP_INPUT, with err->text ready to print, for
 * a character that begins none, an open quote, a number beyond double or an overlong name. */
enum rmap_status rmap_token_read(const char *text, size_t begin, struct rmap_token *token_ret,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* Comments, from a '#' outside of quotes to the line's end, become blanks, so that places stay what
 * they are. */
void rmap_criterion_blank_comments(char *text);

/* True for == != < <= > >=. */
static inline bool rmap_token_is_relation(const struct rmap_token *token)
{
    return token->kind >= RMAP_TOKEN_EQ && token->kind <= RMAP_TOKEN_GE;
}

/* True when the token is this very word. */
bool rmap_token_is(const char *text, const struct rmap_token *token, const char *word);

/* RMAP_INPUT at the first byte that is not UTF-8. */
enum rmap_status rmap_criterion_check_utf8(const char *text, struct rmap_error *err) RMAP_MUST_USE;

/* Writes "criterion:LINE:COLUMN: error: MESSAGE", the line of the text, and a caret under bytes
 * [begin, end). Columns count code points. A long line is shown about the place. Returns
 * RMAP_INPUT. */
enum rmap_status rmap_criterion_fail(const char *text, size_t begin, size_t end,
                                     struct rmap_error *err, const char *format, ...)
    RMAP_PRINTF(5, 6);

/* Makes "criterion:" in front of such a message "LABEL:"; another message stays as it is. */
void rmap_criterion_relabel(const char *label, struct rmap_error *err);

/* A word as a message shows it: cut after a code point, "..." appended, when it is long. */
#define RMAP_SHOWN_NBYTES 64
void rmap_criterion_shorten(const char *word, char shown[RMAP_SHOWN_NBYTES]);

/* The same of a token as it is written, quotes included, up to a line's end. */
void rmap_token_shorten(const char *text, const struct rmap_token *token,
                        char shown[RMAP_SHOWN_NBYTES]);

#endif
