/* SPDX-License-Identifier: MIT
 *
 * A list of everything wrong with an input file, each with file:line:column and the remedy.
 */
#ifndef RMAP_DIAGNOSTICS_H
#define RMAP_DIAGNOSTICS_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "base/status.h"

enum rmap_severity { RMAP_SEVERITY_ERROR, RMAP_SEVERITY_WARNING };

struct rmap_diagnostic {
    enum rmap_severity severity;
    int line, column; /* from 1; 0: the file as a whole */
    char *text;
};

/* A file that the text goes on with, as a scene with what it includes. */
struct rmap_diagnostics_part {
    char *file;
    int first; /* line of the whole text that is its first */
};

struct rmap_diagnostics {
    char *file;
    struct rmap_diagnostics_part *part;
    size_t n_part, cap_part;
    struct rmap_diagnostic *item;
    size_t n, cap;
    size_t n_error;   /* all of them, those without a text too */
    size_t n_dropped; /* past RMAP_DIAGNOSTICS_MAX */
};

void rmap_diagnostics_init(struct rmap_diagnostics *diagnostics, const char *file);
void rmap_diagnostics_fini(struct rmap_diagnostics *diagnostics);

/* From that line on the text is that of another file, until the next begins; told once. */
void rmap_diagnostics_begin_part(struct rmap_diagnostics *diagnostics, int first, const char *file,
                                 size_t file_nbytes);

/* Where an item stands: in which file, NULL for the text's own, and in which line of it. */
const char *rmap_diagnostics_place(const struct rmap_diagnostics *diagnostics, int line,
                                   int *line_ret);

#define RMAP_DIAGNOSTICS_MAX 1000 /* texts kept; what comes after them is counted only */

/* Memory running short drops the text but counts the error. Control characters become '?'. */
void rmap_diagnostics_add(struct rmap_diagnostics *diagnostics, enum rmap_severity severity,
                          int line, int column, const char *format, ...) RMAP_PRINTF(5, 6);

void rmap_diagnostics_vadd(struct rmap_diagnostics *diagnostics, enum rmap_severity severity,
                           int line, int column, const char *format, va_list args);

/* Forgets all behind the first n, as if they had never been found. */
void rmap_diagnostics_cut(struct rmap_diagnostics *diagnostics, size_t n);

/* True when no further text would be kept: no need to compose one. */
bool rmap_diagnostics_full(const struct rmap_diagnostics *diagnostics);

/* "file:line:column: error: text", one per line, sorted by place; four equal ones and more are told
 * at the first's place, with the lines of the others. */
void rmap_diagnostics_print(const struct rmap_diagnostics *diagnostics, FILE *out);

/* Edit distance with case folded; anything above `limit` is limit + 1. */
size_t rmap_word_distance(const char *a, const char *b, size_t limit);

/* The candidate nearest to `word` by edit distance (case-insensitive), if near enough to be
 * worth suggesting; else NULL. A word is not suggested to itself. */
const char *rmap_nearest_word(const char *word, const char *const *candidate, size_t n_candidate);

#endif
