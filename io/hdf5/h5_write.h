/* SPDX-License-Identifier: MIT
 *
 * Attributes and datasets of our own files.
 */
#ifndef RMAP_H5_WRITE_H
#define RMAP_H5_WRITE_H

#include "io/hdf5/h5.h"

/* Attributes of the object at `path`. */
enum rmap_status rmap_h5_put_text(struct rmap_h5 *h5, const char *path, const char *name,
                                  const char *text, struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_h5_put(struct rmap_h5 *h5, const char *path, const char *name,
                             enum rmap_element element, size_t n, const void *data,
                             struct rmap_error *err) RMAP_MUST_USE;

/* The four attributes that every dataset has. */
enum rmap_status rmap_h5_describe(struct rmap_h5 *h5, const char *path, struct rmap_h5_unit unit,
                                  const char *description, struct rmap_error *err) RMAP_MUST_USE;

/* A whole contiguous dataset with its attributes. */
enum rmap_status rmap_h5_write(struct rmap_h5 *h5, const struct rmap_h5_array *array,
                               const void *data, struct rmap_error *err) RMAP_MUST_USE;

/* Fixed-length UTF-8 strings, [n]; NULL entries are empty. n = 0 is fine. */
enum rmap_status rmap_h5_write_names(struct rmap_h5 *h5, const char *path, const char *const *name,
                                     size_t n, const char *description,
                                     struct rmap_error *err) RMAP_MUST_USE;

enum rmap_status rmap_h5_write_fields(struct rmap_h5 *h5, const struct rmap_h5_field *field,
                                      size_t n_field, const void *row, size_t n, size_t row_nbytes,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
