/* SPDX-License-Identifier: MIT
 *
 * Reading through HDF5: types, ranks, extents and checksums are looked at before data are used.
 */
#ifndef RMAP_H5_READ_H
#define RMAP_H5_READ_H

#include "io/hdf5/h5.h"

bool rmap_h5_has(struct rmap_h5 *h5, const char *path);

/* out is always terminated; longer text is cut. */
enum rmap_status rmap_h5_get_text(struct rmap_h5 *h5, const char *path, const char *name, char *out,
                                  size_t out_nbytes, struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_h5_get(struct rmap_h5 *h5, const char *path, const char *name,
                             enum rmap_element element, size_t n, void *out,
                             struct rmap_error *err) RMAP_MUST_USE;

/* The same; out stays as it is where there is no such attribute, as in files of older programs. */
enum rmap_status rmap_h5_get_if(struct rmap_h5 *h5, const char *path, const char *name,
                                enum rmap_element element, size_t n, void *out,
                                struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_h5_get_text_if(struct rmap_h5 *h5, const char *path, const char *name,
                                     char *out, size_t out_nbytes,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* Reads a whole dataset; its rank must be `rank` and its checksum must hold. dims: 0 takes any
 * extent and returns it, others must match. *data_ret: rmap_free. */
enum rmap_status rmap_h5_read(struct rmap_h5 *h5, const char *path, enum rmap_element element,
                              int rank, hsize_t *dims, void **data_ret,
                              struct rmap_error *err) RMAP_MUST_USE;

/* The same of an extent that is known, with rows one every `step` bytes from `rows` on; what is
 * between stays as it is. Where it fails, rows may be half read. */
enum rmap_status rmap_h5_read_rows(struct rmap_h5 *h5, const char *path, enum rmap_element element,
                                   int rank, const hsize_t *dims, void *rows, size_t step,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* *row_ret: n structs of row_nbytes, other members 0; rmap_free. All fields have n rows. */
enum rmap_status rmap_h5_read_fields(struct rmap_h5 *h5, const struct rmap_h5_field *field,
                                     size_t n_field, size_t row_nbytes, void **row_ret,
                                     size_t *n_ret, struct rmap_error *err) RMAP_MUST_USE;

/* [n] strings of *width_ret bytes each, terminated. *text_ret: rmap_free. */
enum rmap_status rmap_h5_read_names(struct rmap_h5 *h5, const char *path, char **text_ret,
                                    size_t *n_ret, size_t *width_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;

#endif
