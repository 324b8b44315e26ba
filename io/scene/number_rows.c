/* SPDX-License-Identifier: MIT
 *
 * A file of rows of numbers over axes.
 */
#include "io/scene/number_rows.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"

void rmap_number_rows_fini(struct rmap_number_rows *rows)
{
    for (size_t c = 0; c < RMAP_ROW_AXES_MAX; c++)
        rmap_free(rows->each[c]);
    rmap_free(rows->row);
    rmap_free(rows->line);
}

static bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == ',' || c == ';';
}

/* The names of the columns, as a first line may have them. */
static bool is_head(const struct rmap_number_rows *rows, const char *at, const char *end)
{
    for (size_t c = 0; c < rows->n_column; c++) {
        const size_t n = strlen(rows->name[c]);
        while (at < end && is_blank(*at))
            at++;
        if ((size_t)(end - at) < n || strncmp(at, rows->name[c], n) != 0)
            return false;
        at += n;
    }
    return true;
}

static enum rmap_status make_room(struct rmap_number_rows *rows, struct rmap_error *err)
{
    const size_t cap = rows->cap ? 2 * rows->cap : 1024;
    void *more = rmap_realloc(rows->row, cap, sizeof *rows->row);
    if (more)
        rows->row = more;
    void *lines = more ? rmap_realloc(rows->line, cap, sizeof *rows->line) : NULL;
    if (!lines)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a table");
    rows->line = lines;
    rows->cap = cap;
    return RMAP_OK;
}

static enum rmap_status read_row(const char *at, const char *end, size_t line,
                                 struct rmap_number_rows *rows, struct rmap_error *err)
{
    enum rmap_status st = rows->n == rows->cap ? make_room(rows, err) : RMAP_OK;
    if (st != RMAP_OK)
        return st;
    for (size_t c = 0; c < rows->n_column; c++) {
        char *stop = NULL;
        double *value = &rows->row[rows->n][c];
        while (at < end && is_blank(*at))
            at++;
        *value = at < end ? strtod(at, &stop) : 0.0;
        if (at >= end || stop == at || stop > end || !isfinite(*value))
            return rmap_error_set(err, RMAP_INPUT, "line %zu: %s", line, rows->row_is);
        at = stop;
    }
    while (at < end && is_blank(*at))
        at++;
    if (at < end && *at != '#')
        return rmap_error_set(err, RMAP_INPUT, "line %zu: something follows its %s numbers", line,
                              rows->n_column == RMAP_ROW_COLUMNS ? "six" : "three");
    rows->line[rows->n++] = line;
    return RMAP_OK;
}

static enum rmap_status read_rows(const char *text, size_t nbytes, struct rmap_number_rows *rows,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const char *at = text, *const end = text + nbytes;
    bool first = true;
    for (size_t line = 1; st == RMAP_OK && at < end; line++) {
        const char *stop = memchr(at, '\n', (size_t)(end - at));
        stop = stop ? stop : end;
        while (at < stop && is_blank(*at))
            at++;
        const bool content = at < stop && *at != '#';
        if (content && !(first && is_head(rows, at, stop)))
            st = read_row(at, stop, line, rows, err);
        first = first && !content;
        at = stop + (stop < end);
    }
    if (st == RMAP_OK && rows->n == 0)
        st = rmap_error_set(err, RMAP_INPUT, "it has no rows: %s", rows->row_is);
    return st;
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static enum rmap_status find_axes(struct rmap_number_rows *rows, struct rmap_error *err)
{
    size_t product = 1;
    for (size_t c = 0; c < rows->n_axis; c++) {
        rows->each[c] = rmap_alloc(rows->n, sizeof *rows->each[c]);
        if (!rows->each[c])
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a table");
        for (size_t i = 0; i < rows->n; i++)
            rows->each[c][i] = rows->row[i][c];
        qsort(rows->each[c], rows->n, sizeof *rows->each[c], ascending);
        for (size_t i = 0; i < rows->n; i++)
            if (i == 0 || rows->each[c][i] != rows->each[c][rows->count[c] - 1])
                rows->each[c][rows->count[c]++] = rows->each[c][i];
        product = product > rows->n ? product : product * rows->count[c];
    }
    rows->stride[rows->n_axis - 1] = 1;
    for (size_t c = rows->n_axis - 1; c > 0; c--)
        rows->stride[c - 1] = rows->stride[c] * rows->count[c];
    for (size_t i = 0; i < rows->n; i++)
        for (size_t c = 0; c < rows->n_axis; c++) {
            const double due = rows->each[c][i / rows->stride[c] % rows->count[c]];
            if (rows->row[i][c] != due)
                return rmap_error_set(err, RMAP_INPUT,
                                      "line %zu: %s %g is out of order: every combination stands "
                                      "there once, ascending, the last column fastest (here %g was "
                                      "due)",
                                      rows->line[i], rows->name[c], rows->row[i][c], due);
        }
    return product == rows->n
               ? RMAP_OK
               : rmap_error_set(err, RMAP_INPUT,
                                "it has %zu rows: some combination of its %s to %s is missing",
                                rows->n, rows->name[0], rows->name[rows->n_axis - 1]);
}

enum rmap_status rmap_number_rows_read(const char *text, size_t nbytes,
                                       struct rmap_number_rows *rows, struct rmap_error *err)
{
    const enum rmap_status st = read_rows(text, nbytes, rows, err);
    return st == RMAP_OK ? find_axes(rows, err) : st;
}

enum rmap_status rmap_table_covers(const double *nm, size_t n, const struct rmap_channels *channels,
                                   struct rmap_error *err)
{
    const double near = 1e-6, first = channels->wavelength_nm[0],
                 last = channels->wavelength_nm[channels->n - 1], from = fmin(first, last),
                 to = fmax(first, last);
    if (nm[0] < 0.0 || (n > 1 && nm[0] == 0.0))
        return rmap_error_set(err, RMAP_INPUT,
                              nm[0] < 0.0 ? "a wavelength of %g nm is none"
                                          : "wavelength %g stands for any, and there are others",
                              nm[0]);
    if ((n == 1 && nm[0] == 0.0) || (nm[0] <= from + near && nm[n - 1] >= to - near))
        return RMAP_OK;
    return rmap_error_set(err, RMAP_INPUT,
                          "it covers %g to %g nm, and the scene has light from %g to %g nm; "
                          "wavelength 0 stands for any",
                          nm[0], nm[n - 1], from, to);
}

size_t rmap_table_between(const double *nm, size_t n, double at, double *part_ret)
{
    size_t low = 0;
    *part_ret = 0.0;
    if (n < 2)
        return 0;
    while (low + 2 < n && at >= nm[low + 1])
        low++;
    const double part = (at - nm[low]) / (nm[low + 1] - nm[low]);
    *part_ret = part < 0.0 ? 0.0 : part < 1.0 ? part : 1.0;
    return low;
}
