/* SPDX-License-Identifier: MIT
 *
 * How every fallible function of Raymap answers: a status of one short list and, in a
 * caller-owned rmap_error, what happened, where, and what to do about it. The lowest layer
 * writes the text; upper layers only add context. Libraries never print, exit or abort.
 */
#ifndef RMAP_STATUS_H
#define RMAP_STATUS_H

#include <stdarg.h>

/* The caller's view. Anything but RMAP_OK leaves outputs unset and releases what was begun. */
enum rmap_status {
    RMAP_OK = 0,
    RMAP_INTERNAL = 1, /* a bug of ours */
    RMAP_USAGE = 2,    /* the command line is wrong */
    RMAP_INPUT = 3,    /* scene, criterion or a name in them is wrong, or a file is missing */
    RMAP_FORMAT = 4,   /* a file exists but is no map, or a damaged one */
    RMAP_SYSTEM = 5,   /* disk full, no memory, no permission, a library failed */
    RMAP_STOPPED = 6,  /* ended early by a signal or a time limit */
    RMAP_LOST = 7      /* traced, but too many rays ended in an error */
};

#define RMAP_ERROR_TEXT_LEN 1024

/* Detail of a failure. Owned by the caller; zero-initialised before first use. */
struct rmap_error {
    enum rmap_status status;
    char text[RMAP_ERROR_TEXT_LEN];
};

#if defined(__GNUC__)
#define RMAP_PRINTF(format_index, first) __attribute__((format(printf, format_index, first)))
#define RMAP_MUST_USE                    __attribute__((warn_unused_result))
#else
#define RMAP_PRINTF(format_index, first)
#define RMAP_MUST_USE
#endif

/* Writes status and text into err (which may be NULL) and returns status. */
enum rmap_status rmap_error_set(struct rmap_error *err, enum rmap_status status, const char *format,
                                ...) RMAP_PRINTF(3, 4);

/* Puts "context: " before the text that err holds already. err may be NULL. */
void rmap_error_context(struct rmap_error *err, const char *format, ...) RMAP_PRINTF(2, 3);

/* Stores the call's status in the local variable `st` and leaves through `out:` on failure. */
#define RMAP_TRY(call)                                                                             \
    do {                                                                                           \
        st = (call);                                                                               \
        if (st != RMAP_OK)                                                                         \
            goto out;                                                                              \
    } while (0)

#endif
