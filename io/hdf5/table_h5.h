/* SPDX-License-Identifier: MIT
 *
 * Tables of numbers, column by column, as an HDF5 file of their own: what h5py, pandas and MATLAB
 * read. Rows come one after another, and as many as there are.
 */
#ifndef RMAP_TABLE_H5_H
#define RMAP_TABLE_H5_H

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"
#include "portion/columns.h"

struct rmap_table_h5_column {
    const char *group, *name; /* "registration", "x" */
    enum rmap_element element;
    const char *unit, *description;
};

struct rmap_table_h5;
struct rmap_h5;

/* Begins a file in place of what stands at `path`, with columns that follow each other group by
 * group; all borrowed for the call, but for the path. RMAP_SYSTEM. */
enum rmap_status rmap_table_h5_begin(const char *path, const struct rmap_table_h5_column *column,
                                     size_t n, struct rmap_table_h5 **table_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* An attribute of the file. */
enum rmap_status rmap_table_h5_put_text(struct rmap_table_h5 *table, const char *name,
                                        const char *text, struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_table_h5_put_number(struct rmap_table_h5 *table, const char *name,
                                          enum rmap_element element, const void *value,
                                          struct rmap_error *err) RMAP_MUST_USE;
/* Names that numbers of a column stand for, as the dataset "/name/NAME". */
enum rmap_status rmap_table_h5_put_names(struct rmap_table_h5 *table, const char *name,
                                         const char *const *text, size_t n, const char *description,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* A row more at the end of column c: an element as the column has it. RMAP_SYSTEM. */
enum rmap_status rmap_table_h5_add(struct rmap_table_h5 *table, size_t c, const void *element,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* The file, for more attributes. */
struct rmap_h5 *rmap_table_h5_file(struct rmap_table_h5 *table);

/* Gives the file its name. seals: as a file of a map (io/file/seal.h). RMAP_SYSTEM. */
enum rmap_status rmap_table_h5_finish(struct rmap_table_h5 *table, bool seals,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* Removes a file that was not finished, and releases. NULL is fine. */
void rmap_table_h5_destroy(struct rmap_table_h5 *table);

#endif
