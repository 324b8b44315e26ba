/* SPDX-License-Identifier: MIT
 *
 * A table of text with aligned columns. Cells come row by row, headings first. Like the picture
 * writer it keeps its first error (memory) until the end.
 */
#ifndef RMAP_TEXT_TABLE_H
#define RMAP_TEXT_TABLE_H

#include <stddef.h>
#include <stdio.h>

#include "base/status.h"

struct rmap_text_table {
    size_t n_column, n_cell, cap;
    char **cell; /* [n_cell], owned */
    enum rmap_status status;
};

void rmap_text_table_init(struct rmap_text_table *table, size_t n_column);
void rmap_text_table_fini(struct rmap_text_table *table);

/* The next cell, left to right, row after row. */
void rmap_text_table_add(struct rmap_text_table *table, const char *format, ...) RMAP_PRINTF(2, 3);

/* Prints all full rows, two blanks between columns; `alignment` has one character per column, 'l'
 * or 'r'. RMAP_SYSTEM when memory ran short on the way. */
enum rmap_status rmap_text_table_print(const struct rmap_text_table *table, const char *alignment,
                                       FILE *out, struct rmap_error *err) RMAP_MUST_USE;

#endif
