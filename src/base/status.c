/* SPDX-License-Identifier: MIT
 *
 * How every fallible function of Raymap answers: a status of one short list and, in a caller-owned
 * rmap_error, what happened, where, and what to do about it.
 */
#include "base/status.h"

#include <stdio.h>
#include <string.h>

enum rmap_status rmap_error_set(struct rmap_error *err, enum rmap_status status, const char *format,
                                ...)
{
    if (!err)
        return status;
    err->status = status;
    va_list args;
    va_start(args, format);
    (void)vsnprintf(err->text, sizeof err->text, format, args);
    va_end(args);
    return status;
}

/* Appends what fits; returns the new length. */
static size_t append(char *text, size_t used, const char *more)
{
    size_t room = RMAP_ERROR_TEXT_LEN - 1 - used;
    size_t n = strnlen(more, room);
    memcpy(text + used, more, n);
    text[used + n] = '\0';
    return used + n;
}

void rmap_error_context(struct rmap_error *err, const char *format, ...)
{
    if (!err)
        return;
    char inner[RMAP_ERROR_TEXT_LEN];
    memcpy(inner, err->text, sizeof inner);
    va_list args;
    va_start(args, format);
    (void)vsnprintf(err->text, sizeof err->text, format, args);
    va_end(args);
    size_t used = append(err->text, strlen(err->text), ": ");
    (void)append(err->text, used, inner);
}
