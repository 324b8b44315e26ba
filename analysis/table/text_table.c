/* SPDX-License-Identifier: MIT
 *
 * A table of text with aligned columns.
 */
#include "analysis/table/text_table.h"

#include <string.h>

#include "base/alloc.h"

void rmap_text_table_init(struct rmap_text_table *table, size_t n_column)
{
    *table = (struct rmap_text_table){.n_column = n_column};
}

void rmap_text_table_fini(struct rmap_text_table *table)
{
    for (size_t i = 0; i < table->n_cell; i++)
        rmap_free(table->cell[i]);
    rmap_free(table->cell);
    *table = (struct rmap_text_table){0};
}

void rmap_text_table_add(struct rmap_text_table *table, const char *format, ...)
{
    char text[512];
    va_list args;
    va_start(args, format);
    (void)vsnprintf(text, sizeof text, format, args);
    va_end(args);
    if (table->status != RMAP_OK)
        return;
    table->status = RMAP_RESERVE(table->cell, table->cap, table->n_cell + 1, NULL);
    char *copy = table->status == RMAP_OK ? rmap_strdup(text) : NULL;
    if (copy)
        table->cell[table->n_cell++] = copy;
    else
        table->status = RMAP_SYSTEM;
}

/* Characters, not bytes. */
static size_t width_of(const char *text)
{
    size_t n = 0;
    for (; *text; text++)
        n += ((unsigned char)*text & 0xc0) != 0x80;
    return n;
}

static void print_row(char *const *cell, const size_t *width, const char *alignment, size_t n,
                      FILE *out)
{
    for (size_t c = 0; c < n; c++) {
        int pad = (int)(width[c] - width_of(cell[c]));
        if (alignment[c] == 'r')
            fprintf(out, "%*s%s", pad, "", cell[c]);
        else
            fprintf(out, "%s%*s", cell[c], c + 1 < n ? pad : 0, "");
        fputs(c + 1 < n ? "  " : "\n", out);
    }
}

enum rmap_status rmap_text_table_print(const struct rmap_text_table *table, const char *alignment,
                                       FILE *out, struct rmap_error *err)
{
    size_t *width = rmap_alloc(table->n_column, sizeof *width);
    if (!width || table->status != RMAP_OK) {
        rmap_free(width);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a table");
    }
    for (size_t i = 0; i < table->n_cell; i++) {
        size_t w = width_of(table->cell[i]);
        if (w > width[i % table->n_column])
            width[i % table->n_column] = w;
    }
    for (size_t i = 0; i + table->n_column <= table->n_cell; i += table->n_column)
        print_row(table->cell + i, width, alignment, table->n_column, out);
    rmap_free(width);
    return RMAP_OK;
}
