/* SPDX-License-Identifier: MIT */
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

void rmap_error_context(struct rmap_error *err, const char *format, ...)
{
    if (!err)
        return;
    char inner[RMAP_ERROR_TEXT_LEN];
    memcpy(inner, err->text, sizeof inner);
    va_list args;
    va_start(args, format);
    int used = vsnprintf(err->text, sizeof err->text, format, args);
    va_end(args);
    if (used < 0 || (size_t)used >= sizeof err->text)
        return;
    (void)snprintf(err->text + used, sizeof err->text - (size_t)used, ": %s", inner);
}
