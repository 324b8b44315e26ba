/* SPDX-License-Identifier: MIT
 *
 * Numbers over a grid as a file for other programs.
 */
#ifndef RMAP_GRID_OUT_H
#define RMAP_GRID_OUT_H

#include "io/hdf5/grid_h5.h"

/* OUT.h5: all arrays and the texts; OUT.npz: all arrays; OUT.npy: the first. RMAP_SYSTEM. */
enum rmap_status rmap_grid_write(const struct rmap_grid_array *array, size_t n_array,
                                 const struct rmap_grid_text *text, size_t n_text, const char *path,
                                 struct rmap_error *err) RMAP_MUST_USE;

#endif
