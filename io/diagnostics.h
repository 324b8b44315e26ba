/* SPDX-License-Identifier: MIT
 *
 * A list of everything wrong with an input file, each with file:line:column and the remedy.
 */
#ifndef RMAP_DIAGNOSTICS_H
#define RMAP_DIAGNOSTICS_H

#include <stddef.h>
#include <stdio.h>

#include "base/status.h"

enum rmap_severity { RMAP_SEVERITY_ERROR, RMAP_SEVERITY_WARNING };

struct rmap_diagnostic {
    enum rmap_severity severity;
    int line, column; /* from 1; 0: the file as a whole */
    char *text;
};

struct rmap_diagnostics {
    char *file;
    struct rmap_diagnostic *item;
    size_t n, cap;
    size_t n_error;
};

void rmap_diagnostics_init(struct rmap_diagnostics *diagnostics, const char *file);
void rmap_diagnostics_fini(struct rmap_diagnostics *diagnostics);

/* Memory running short drops the text but counts the error. */
void rmap_diagnostics_add(struct rmap_diagnostics *diagnostics, enum rmap_severity severity,
                          int line, int column, const char *format, ...) RMAP_PRINTF(5, 6);

/* "file:line:column: error: text", one per line, sorted by place. */
void rmap_diagnostics_print(const struct rmap_diagnostics *diagnostics, FILE *out);

/* The candidate nearest to `word` by edit distance (case-insensitive), if near enough to be
 * worth suggesting; else NULL. */
const char *rmap_nearest_word(const char *word, const char *const *candidate, size_t n_candidate);

#endif
