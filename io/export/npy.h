/* SPDX-License-Identifier: MIT
 *
 * Arrays of doubles for NumPy: one as .npy, several with their names as .npz (the format's
 * version 1.0, numpy.org/doc/stable/reference/generated/numpy.lib.format.html; .npz is a ZIP
 * archive of them, stored: APPNOTE.TXT 6.3.3).
 */
#ifndef RMAP_NPY_H
#define RMAP_NPY_H

#include <stddef.h>

#include "base/status.h"

#define RMAP_NPY_RANK_MAX 4

struct rmap_npy_array {
    const char *name; /* in an .npz: letters, digits and _ */
    int rank;
    size_t dims[RMAP_NPY_RANK_MAX]; /* slowest first */
    const double *data;
};

/* Replaces what is there. RMAP_SYSTEM, with nothing left behind; an archive holds 4 GB at most:
 * RMAP_USAGE. */
enum rmap_status rmap_npy_write(const struct rmap_npy_array *array, const char *path,
                                struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_npz_write(const struct rmap_npy_array *array, size_t n, const char *path,
                                struct rmap_error *err) RMAP_MUST_USE;

#endif
