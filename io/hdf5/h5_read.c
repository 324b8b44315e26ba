/* SPDX-License-Identifier: MIT
 *
 * Reading through HDF5: types, ranks, extents and checksums are looked at before data are used.
 */
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "io/codec/codec.h"
#include "io/hdf5/h5.h"
#include "io/hdf5/h5_deflate.h"
#include "io/hdf5/h5_inside.h"
#include "io/hdf5/h5_read.h"

bool rmap_h5_has(struct rmap_h5 *h5, const char *path)
{
    return H5Lexists(h5->file, path, H5P_DEFAULT) > 0 &&
           H5Oexists_by_name(h5->file, path, H5P_DEFAULT) > 0;
}

enum rmap_status rmap_h5_get_text(struct rmap_h5 *h5, const char *path, const char *name, char *out,
                                  size_t out_nbytes, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    hid_t memory = H5I_INVALID_HID;
    hid_t attribute = H5Aopen_by_name(h5->file, path, name, H5P_DEFAULT, H5P_DEFAULT);
    hid_t type = attribute < 0 ? H5I_INVALID_HID : H5Aget_type(attribute);
    hid_t space = attribute < 0 ? H5I_INVALID_HID : H5Aget_space(attribute);
    memset(out, 0, out_nbytes);
    if (type < 0 || space < 0 || H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) ||
        H5Sget_simple_extent_npoints(space) != 1 || (memory = H5Tcopy(H5T_C_S1)) < 0 ||
        H5Tset_size(memory, out_nbytes) < 0 || H5Tset_cset(memory, H5Tget_cset(type)) < 0 ||
        H5Aread(attribute, memory, out) < 0)
        st = rmap_h5_fail(h5, name, err);
    out[out_nbytes - 1] = 0;
    (void)H5Tclose(memory);
    (void)H5Tclose(type);
    (void)H5Sclose(space);
    (void)H5Aclose(attribute);
    return st;
}

enum rmap_status rmap_h5_get(struct rmap_h5 *h5, const char *path, const char *name,
                             enum rmap_element element, size_t n, void *out, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    hid_t attribute = H5Aopen_by_name(h5->file, path, name, H5P_DEFAULT, H5P_DEFAULT);
    hid_t type = attribute < 0 ? H5I_INVALID_HID : H5Aget_type(attribute);
    hid_t space = attribute < 0 ? H5I_INVALID_HID : H5Aget_space(attribute);
    if (type < 0 || space < 0 || H5Tequal(type, rmap_h5_type(element)) <= 0 ||
        H5Sget_simple_extent_npoints(space) != (hssize_t)n ||
        H5Aread(attribute, rmap_h5_type(element), out) < 0)
        st = rmap_h5_fail(h5, name, err);
    (void)H5Tclose(type);
    (void)H5Sclose(space);
    (void)H5Aclose(attribute);
    return st;
}

enum rmap_status rmap_h5_get_if(struct rmap_h5 *h5, const char *path, const char *name,
                                enum rmap_element element, size_t n, void *out,
                                struct rmap_error *err)
{
    const htri_t there = H5Aexists_by_name(h5->file, path, name, H5P_DEFAULT);
    if (there < 0)
        return rmap_h5_fail(h5, name, err);
    return there > 0 ? rmap_h5_get(h5, path, name, element, n, out, err) : RMAP_OK;
}

enum rmap_status rmap_h5_get_text_if(struct rmap_h5 *h5, const char *path, const char *name,
                                     char *out, size_t out_nbytes, struct rmap_error *err)
{
    const htri_t there = H5Aexists_by_name(h5->file, path, name, H5P_DEFAULT);
    if (there < 0)
        return rmap_h5_fail(h5, name, err);
    return there > 0 ? rmap_h5_get_text(h5, path, name, out, out_nbytes, err) : RMAP_OK;
}

static enum rmap_status wrong(struct rmap_h5 *h5, const char *path, const char *what,
                              struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_FORMAT, "%s: %s %s", h5->path, path, what);
}

/* exact: an extent of 0 takes no other, either. */
static enum rmap_status get_extent(struct rmap_h5 *h5, const char *path, hid_t set, int rank,
                                   hsize_t *dims, bool exact, struct rmap_error *err)
{
    hsize_t have[RMAP_H5_RANK_MAX] = {0};
    hid_t space = H5Dget_space(set);
    int have_rank = space < 0 ? -1 : H5Sget_simple_extent_ndims(space);
    bool fits = have_rank == rank && H5Sget_simple_extent_dims(space, have, NULL) == rank;
    (void)H5Sclose(space);
    if (!fits)
        return wrong(h5, path, "has another number of dimensions than a ray map's", err);
    for (int k = 0; k < rank; k++) {
        if ((exact || dims[k]) && dims[k] != have[k])
            return wrong(h5, path, "has another shape than the map says", err);
        dims[k] = have[k];
    }
    return RMAP_OK;
}

static enum rmap_status check_sum(struct rmap_h5 *h5, const char *path, uint64_t have,
                                  struct rmap_error *err)
{
    uint64_t sum;
    enum rmap_status st = rmap_h5_get(h5, path, "checksum", RMAP_U64, 1, &sum, err);
    if (st == RMAP_OK && sum != have)
        st = wrong(h5, path, "is damaged: its checksum does not match", err);
    return st;
}

/* Reads all of an open dataset of elements of `cell` bytes: its rows one every `step` bytes from
 * `rows` on or, where that is NULL, into memory of their own. */
static enum rmap_status read_data(struct rmap_h5 *h5, const char *path, hid_t set, hid_t type,
                                  size_t cell, int rank, hsize_t *dims, void *rows, size_t step,
                                  void **data_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    void *data = NULL;
    uint64_t nbytes = cell, sum = 0;
    RMAP_TRY(get_extent(h5, path, set, rank, dims, rows != NULL, err));
    /* A wrong extent must not become a huge allocation. */
    const uint64_t deflate_ratio_max = 1032; /* RFC 1951: 258 bytes from 2 bits */
    uint64_t most = H5Dget_storage_size(set) * deflate_ratio_max;
    for (int k = 0; k < rank; k++)
        nbytes = dims[k] == 0 ? 0 : nbytes;
    for (int k = 0; k < rank; k++) {
        if (nbytes > 0 && nbytes > most / dims[k]) {
            st = wrong(h5, path, "claims to be larger than its file can hold", err);
            goto out;
        }
        nbytes *= dims[k];
    }
    const bool is_number = cell == 1 || cell == 2 || cell == 4 || cell == 8;
    const size_t row = nbytes > 0 ? (size_t)(nbytes / dims[0]) : 0;
    bool is_read = rows && nbytes > 0 && is_number &&
                   rmap_h5_read_tiles(set, rank, dims, cell, rows, step, &sum);
    if (!is_read) {
        data = rmap_alloc(nbytes, 1);
        if (!data) {
            st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %s of %s", path, h5->path);
            goto out;
        }
        is_read = !rows && nbytes > 0 && is_number &&
                  rmap_h5_read_tiles(set, rank, dims, cell, data, row, &sum);
    }
    if (!is_read) {
        if (nbytes > 0 && H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0) {
            st = rmap_h5_fail(h5, path, err);
            goto out;
        }
        sum = rmap_checksum(data, nbytes);
        for (size_t i = 0; rows && row > 0 && i < dims[0]; i++)
            memcpy((char *)rows + i * step, (char *)data + i * row, row);
    }
    RMAP_TRY(check_sum(h5, path, sum, err));
    *data_ret = data;
    data = NULL;
out:
    rmap_free(data);
    return st;
}

static enum rmap_status read_numbers(struct rmap_h5 *h5, const char *path,
                                     enum rmap_element element, int rank, hsize_t *dims, void *rows,
                                     size_t step, void **data_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    hid_t type = rmap_h5_type(element);
    hid_t set = rmap_h5_dataset(h5->file, path);
    hid_t have = set < 0 ? H5I_INVALID_HID : H5Dget_type(set);
    if (have < 0 || H5Tequal(have, type) <= 0)
        st = rmap_h5_fail(h5, path, err);
    else
        st = read_data(h5, path, set, type, rmap_element_nbytes(element), rank, dims, rows, step,
                       data_ret, err);
    (void)H5Tclose(have);
    (void)H5Dclose(set);
    return st;
}

enum rmap_status rmap_h5_read(struct rmap_h5 *h5, const char *path, enum rmap_element element,
                              int rank, hsize_t *dims, void **data_ret, struct rmap_error *err)
{
    return read_numbers(h5, path, element, rank, dims, NULL, 0, data_ret, err);
}

enum rmap_status rmap_h5_read_rows(struct rmap_h5 *h5, const char *path, enum rmap_element element,
                                   int rank, const hsize_t *dims, void *rows, size_t step,
                                   struct rmap_error *err)
{
    hsize_t want[RMAP_H5_RANK_MAX] = {0};
    void *data = NULL;
    memcpy(want, dims, (size_t)rank * sizeof *want);
    const enum rmap_status st = read_numbers(h5, path, element, rank, want, rows, step, &data, err);
    rmap_free(data);
    return st;
}

enum rmap_status rmap_h5_read_fields(struct rmap_h5 *h5, const struct rmap_h5_field *field,
                                     size_t n_field, size_t row_nbytes, void **row_ret,
                                     size_t *n_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t first_nbytes = field->width * rmap_element_nbytes(field->element);
    hsize_t dims[2] = {0, field->width};
    void *first = NULL;
    char *row = NULL;
    /* How many rows there are is believed once those of the first field are there. */
    RMAP_TRY(rmap_h5_read(h5, field->path, field->element, field->width == 1 ? 1 : 2, dims, &first,
                          err));
    const size_t n = (size_t)dims[0];
    row = rmap_alloc(n, row_nbytes);
    if (!row)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for %s", field->path));
    for (size_t i = 0; i < n; i++)
        memcpy(row + i * row_nbytes + field->offset, (char *)first + i * first_nbytes,
               first_nbytes);
    for (const struct rmap_h5_field *f = field + 1; f < field + n_field; f++) {
        dims[1] = f->width;
        RMAP_TRY(rmap_h5_read_rows(h5, f->path, f->element, f->width == 1 ? 1 : 2, dims,
                                   row + f->offset, row_nbytes, err));
    }
    *row_ret = row;
    *n_ret = n;
    row = NULL;
out:
    rmap_free(first);
    rmap_free(row);
    return st;
}

enum rmap_status rmap_h5_read_names(struct rmap_h5 *h5, const char *path, char **text_ret,
                                    size_t *n_ret, size_t *width_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    void *data = NULL;
    hsize_t n = 0;
    hid_t set = rmap_h5_dataset(h5->file, path);
    hid_t type = set < 0 ? H5I_INVALID_HID : H5Dget_type(set);
    size_t width = type < 0 ? 0 : H5Tget_size(type);
    if (width == 0 || H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type))
        st = rmap_h5_fail(h5, path, err);
    else
        st = read_data(h5, path, set, type, width, 1, &n, NULL, 0, &data, err);
    (void)H5Tclose(type);
    (void)H5Dclose(set);
    if (st != RMAP_OK)
        return st;
    char *text = rmap_alloc((size_t)n, width + 1);
    if (!text)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the names in %s", path);
    for (size_t i = 0; text && i < n; i++)
        memcpy(text + i * (width + 1), (char *)data + i * width, width);
    rmap_free(data);
    *text_ret = text;
    *n_ret = (size_t)n;
    *width_ret = width + 1;
    return st;
}
