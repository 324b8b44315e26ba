/* SPDX-License-Identifier: MIT
 *
 * A file of rows of numbers over axes: blanks, commas or semicolons between them, '#' before
 * remarks, the names of the columns perhaps in the first line.
 */
#ifndef RMAP_NUMBER_ROWS_H
#define RMAP_NUMBER_ROWS_H

#include <stddef.h>

#include "base/status.h"
#include "optics/spectrum.h"

enum { RMAP_ROW_COLUMNS = 6, RMAP_ROW_AXES_MAX = 5 }; /* at most */

struct rmap_number_rows {
    size_t n_column;
    const char *const *name; /* [n_column]; the first n_axis are axes */
    const char *row_is;      /* "a row has six numbers: ..." */
    size_t n_axis;
    /* Read. */
    double (*row)[RMAP_ROW_COLUMNS]; /* [n] */
    size_t *line;                    /* [n] from 1 */
    size_t n, cap;
    /* The distinct numbers of each axis, ascending, and how many rows one step of it is. */
    double *each[RMAP_ROW_AXES_MAX];
    size_t count[RMAP_ROW_AXES_MAX], stride[RMAP_ROW_AXES_MAX];
};

/* Every combination of the axes' numbers once, ascending, the last axis fastest; all finite.
 * n_column, name, row_is and n_axis are set. RMAP_INPUT with the line. */
enum rmap_status rmap_number_rows_read(const char *text, size_t nbytes,
                                       struct rmap_number_rows *rows,
                                       struct rmap_error *err) RMAP_MUST_USE;
void rmap_number_rows_fini(struct rmap_number_rows *rows);

/* Wavelengths [n] of a table, ascending, hold all of the scene's: RMAP_INPUT with both ranges. One
 * wavelength 0 stands for any. */
enum rmap_status rmap_table_covers(const double *nm, size_t n, const struct rmap_channels *channels,
                                   struct rmap_error *err) RMAP_MUST_USE;
/* The row below `at`, and how far it is to the next, 0 to 1 (0 where there is none). */
size_t rmap_table_between(const double *nm, size_t n, double at, double *part_ret);

#endif
