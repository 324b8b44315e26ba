/* SPDX-License-Identifier: MIT
 *
 * A list of everything wrong with an input file, each with file:line:column and the remedy.
 */
#include "io/file/diagnostics.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"

void rmap_diagnostics_init(struct rmap_diagnostics *diagnostics, const char *file)
{
    *diagnostics = (struct rmap_diagnostics){.file = rmap_strdup(file)};
}

void rmap_diagnostics_fini(struct rmap_diagnostics *diagnostics)
{
    for (size_t i = 0; i < diagnostics->n; i++)
        rmap_free(diagnostics->item[i].text);
    rmap_free(diagnostics->item);
    rmap_free(diagnostics->file);
    *diagnostics = (struct rmap_diagnostics){0};
}

void rmap_diagnostics_add(struct rmap_diagnostics *diagnostics, enum rmap_severity severity,
                          int line, int column, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    rmap_diagnostics_vadd(diagnostics, severity, line, column, format, args);
    va_end(args);
}

/* What comes from a file must not steer the terminal that shows it. */
static void blank_controls(char *text)
{
    for (; *text; text++)
        if ((unsigned char)*text < ' ' || *text == 127)
            *text = '?';
}

void rmap_diagnostics_vadd(struct rmap_diagnostics *diagnostics, enum rmap_severity severity,
                           int line, int column, const char *format, va_list args)
{
    if (severity == RMAP_SEVERITY_ERROR)
        diagnostics->n_error++;
    if (rmap_diagnostics_full(diagnostics)) {
        diagnostics->n_dropped++;
        return;
    }
    char text[RMAP_ERROR_TEXT_LEN];
    (void)vsnprintf(text, sizeof text, format, args);
    blank_controls(text);
    if (RMAP_RESERVE(diagnostics->item, diagnostics->cap, diagnostics->n + 1, NULL) != RMAP_OK)
        return;
    char *copy = rmap_strdup(text);
    if (!copy)
        return;
    diagnostics->item[diagnostics->n++] = (struct rmap_diagnostic){
        .severity = severity, .line = line, .column = column, .text = copy};
}

bool rmap_diagnostics_full(const struct rmap_diagnostics *diagnostics)
{
    return diagnostics->n >= RMAP_DIAGNOSTICS_MAX;
}

static int by_place(const void *a, const void *b)
{
    const struct rmap_diagnostic *left = *(const struct rmap_diagnostic *const *)a;
    const struct rmap_diagnostic *right = *(const struct rmap_diagnostic *const *)b;
    if (left->line != right->line)
        return left->line < right->line ? -1 : 1;
    if (left->column != right->column)
        return left->column < right->column ? -1 : 1;
    return left < right ? -1 : left > right;
}

static void print_item(const char *file, const struct rmap_diagnostic *item, FILE *out)
{
    const char *kind = item->severity == RMAP_SEVERITY_ERROR ? "error" : "warning";
    if (item->line > 0)
        fprintf(out, "%s:%d:%d: %s: %s\n", file, item->line, item->column, kind, item->text);
    else
        fprintf(out, "%s: %s: %s\n", file, kind, item->text);
}

void rmap_diagnostics_print(const struct rmap_diagnostics *diagnostics, FILE *out)
{
    const char *file = diagnostics->file ? diagnostics->file : "scene";
    const struct rmap_diagnostic **order = rmap_alloc(diagnostics->n, sizeof(void *));
    for (size_t i = 0; order && i < diagnostics->n; i++)
        order[i] = &diagnostics->item[i];
    if (order)
        qsort(order, diagnostics->n, sizeof(void *), by_place);
    for (size_t i = 0; i < diagnostics->n; i++)
        print_item(file, order ? order[i] : &diagnostics->item[i], out);
    if (diagnostics->n_dropped)
        fprintf(out, "%s: and %zu more\n", file, diagnostics->n_dropped);
    rmap_free(order);
}

size_t rmap_word_distance(const char *a, const char *b, size_t limit)
{
    enum { LONGEST = 64 };
    size_t n = strlen(a), m = strlen(b);
    if (n > LONGEST || m > LONGEST || (n > m ? n - m : m - n) > limit)
        return limit + 1;
    size_t row[LONGEST + 1];
    for (size_t j = 0; j <= m; j++)
        row[j] = j;
    for (size_t i = 1; i <= n; i++) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= m; j++) {
            size_t change =
                diagonal + (tolower((unsigned char)a[i - 1]) != tolower((unsigned char)b[j - 1]));
            size_t skip = (row[j] < row[j - 1] ? row[j] : row[j - 1]) + 1;
            diagonal = row[j];
            row[j] = change < skip ? change : skip;
        }
    }
    return row[m] <= limit ? row[m] : limit + 1;
}

const char *rmap_nearest_word(const char *word, const char *const *candidate, size_t n_candidate)
{
    size_t limit = strlen(word) / 3 + 1;
    const char *nearest = NULL;
    for (size_t i = 0; i < n_candidate; i++) {
        size_t distance = candidate[i] ? rmap_word_distance(word, candidate[i], limit) : limit + 1;
        if (distance <= limit && !(nearest && distance == limit)) {
            nearest = candidate[i];
            limit = distance;
        }
    }
    return nearest;
}
