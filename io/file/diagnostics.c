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
    for (size_t i = 0; i < diagnostics->n_part; i++)
        rmap_free(diagnostics->part[i].file);
    rmap_free(diagnostics->part);
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

void rmap_diagnostics_begin_part(struct rmap_diagnostics *diagnostics, int first, const char *file,
                                 size_t file_nbytes)
{
    for (size_t i = 0; i < diagnostics->n_part; i++)
        if (diagnostics->part[i].first == first)
            return;
    char *name = rmap_alloc(file_nbytes + 1, 1);
    if (!name || RMAP_RESERVE(diagnostics->part, diagnostics->cap_part, diagnostics->n_part + 1,
                              NULL) != RMAP_OK) {
        rmap_free(name);
        return;
    }
    memcpy(name, file, file_nbytes);
    blank_controls(name);
    diagnostics->part[diagnostics->n_part++] = (struct rmap_diagnostics_part){name, first};
}

const char *rmap_diagnostics_place(const struct rmap_diagnostics *diagnostics, int line,
                                   int *line_ret)
{
    const char *file = NULL;
    *line_ret = line;
    for (size_t i = 0; i < diagnostics->n_part; i++)
        if (line >= diagnostics->part[i].first) {
            file = diagnostics->part[i].file;
            *line_ret = line - diagnostics->part[i].first + 1;
        }
    return file;
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

void rmap_diagnostics_cut(struct rmap_diagnostics *diagnostics, size_t n)
{
    for (; diagnostics->n > n; rmap_free(diagnostics->item[--diagnostics->n].text))
        diagnostics->n_error -=
            diagnostics->item[diagnostics->n - 1].severity == RMAP_SEVERITY_ERROR;
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

static void print_item(const struct rmap_diagnostics *diagnostics,
                       const struct rmap_diagnostic *item, FILE *out)
{
    const char *kind = item->severity == RMAP_SEVERITY_ERROR ? "error" : "warning";
    int line;
    const char *part = rmap_diagnostics_place(diagnostics, item->line, &line);
    const char *own = diagnostics->file ? diagnostics->file : "scene", *file = part ? part : own;
    const char *slash = part && part[0] != '/' ? strrchr(own, '/') : NULL;
    fprintf(out, "%.*s%s:", slash ? (int)(slash - own) + 1 : 0, own, file); /* as a path to it */
    if (item->line > 0)
        fprintf(out, "%d:%d:", line, item->column);
    fprintf(out, " %s: %s", kind, item->text);
}

/* From so many equal mistakes on they are told once, at the place of the first. */
enum { EQUAL_TOLD = 4, LINES_TOLD = 8 };

static bool is_same(const struct rmap_diagnostic *a, const struct rmap_diagnostic *b)
{
    return b && a->line > 0 && b->line > 0 && a->severity == b->severity &&
           strcmp(a->text, b->text) == 0;
}

/* The first of n items, with those that say the same where there are many: they become NULL. */
static void print_equals(const struct rmap_diagnostics *diagnostics,
                         const struct rmap_diagnostic **item, size_t n, FILE *out)
{
    size_t n_equal = 0, told = 0;
    for (size_t i = 0; i < n; i++)
        n_equal += is_same(item[0], item[i]);
    print_item(diagnostics, item[0], out);
    if (n_equal >= EQUAL_TOLD)
        fprintf(out, " (%zu times, also in line", n_equal);
    for (size_t i = 1; i < n && n_equal >= EQUAL_TOLD; i++) {
        if (!is_same(item[0], item[i]))
            continue;
        if (told < LINES_TOLD)
            fprintf(out, "%s %d", told ? "," : "", item[i]->line);
        else if (told == LINES_TOLD)
            fputs(", ...", out);
        item[i] = NULL;
        told++;
    }
    fputs(n_equal >= EQUAL_TOLD ? ")\n" : "\n", out);
}

void rmap_diagnostics_print(const struct rmap_diagnostics *diagnostics, FILE *out)
{
    const char *file = diagnostics->file ? diagnostics->file : "scene";
    const struct rmap_diagnostic **order = rmap_alloc(diagnostics->n + 1, sizeof(void *));
    for (size_t i = 0; i < diagnostics->n; i++) {
        if (order)
            order[i] = &diagnostics->item[i];
        else
            print_equals(diagnostics, (const struct rmap_diagnostic *[]){&diagnostics->item[i]}, 1,
                         out);
    }
    if (order)
        qsort(order, diagnostics->n, sizeof(void *), by_place);
    for (size_t i = 0; order && i < diagnostics->n; i++)
        if (order[i])
            print_equals(diagnostics, order + i, diagnostics->n - i, out);
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
        if (candidate[i] && strcmp(word, candidate[i]) == 0)
            continue; /* it is known, and wrong for another reason */
        if (distance <= limit && distance < strlen(word) && !(nearest && distance == limit)) {
            nearest = candidate[i];
            limit = distance;
        }
    }
    return nearest;
}
