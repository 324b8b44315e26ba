/* SPDX-License-Identifier: MIT
 *
 * Numbers over the cells of a grid as an HDF5 file of their own: a detector's picture.
 */
#ifndef RMAP_GRID_H5_H
#define RMAP_GRID_H5_H

#include <stddef.h>

#include "base/status.h"

struct rmap_grid_array {
    const char *name; /* "value" */
    const char *unit, *description;
    int rank;       /* 1 to 3 */
    size_t dims[3]; /* slowest first */
    const double *data;
};

struct rmap_grid_text {
    const char *name, *text; /* an attribute of the file */
};

/* A new file in place of what stands there. RMAP_SYSTEM. */
enum rmap_status rmap_grid_h5_write(const char *path, const struct rmap_grid_array *array,
                                    size_t n_array, const struct rmap_grid_text *text,
                                    size_t n_text, struct rmap_error *err) RMAP_MUST_USE;

#endif
