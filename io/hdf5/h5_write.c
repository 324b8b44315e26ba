/* SPDX-License-Identifier: MIT
 *
 * Attributes and datasets of our own files.
 */
#include "io/hdf5/h5.h"

#include <string.h>

#include "base/alloc.h"
#include "io/codec/codec.h"
#include "io/hdf5/h5_deflate.h"
#include "io/hdf5/h5_write.h"

/* A fixed-length, null-padded UTF-8 string type. */
static hid_t string_type(size_t nbytes)
{
    hid_t type = H5Tcopy(H5T_C_S1);
    if (type >= 0 &&
        (H5Tset_size(type, nbytes ? nbytes : 1) < 0 || H5Tset_cset(type, H5T_CSET_UTF8) < 0 ||
         H5Tset_strpad(type, H5T_STR_NULLPAD) < 0)) {
        (void)H5Tclose(type);
        type = H5I_INVALID_HID;
    }
    return type;
}

static enum rmap_status put_attribute(struct rmap_h5 *h5, hid_t object, const char *name,
                                      hid_t type, hid_t space, const void *data,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    hid_t attribute = H5I_INVALID_HID;
    if (object < 0 || type < 0 || space < 0 ||
        (attribute = H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT)) < 0 ||
        H5Awrite(attribute, type, data) < 0)
        st = rmap_h5_fail(h5, name, err);
    if (attribute >= 0 && !h5->failed && H5Aclose(attribute) < 0)
        st = rmap_h5_fail(h5, name, err);
    return st;
}

static enum rmap_status put_text(struct rmap_h5 *h5, hid_t object, const char *name,
                                 const char *text, struct rmap_error *err)
{
    hid_t type = string_type(strlen(text)), space = H5Screate(H5S_SCALAR);
    enum rmap_status st = put_attribute(h5, object, name, type, space, text, err);
    (void)H5Tclose(type);
    (void)H5Sclose(space);
    return st;
}

static enum rmap_status put_numbers(struct rmap_h5 *h5, hid_t object, const char *name,
                                    enum rmap_element element, size_t n, const void *data,
                                    struct rmap_error *err)
{
    hsize_t dims = n;
    hid_t space = n == 1 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &dims, NULL);
    enum rmap_status st = put_attribute(h5, object, name, rmap_h5_type(element), space, data, err);
    (void)H5Sclose(space);
    return st;
}

static enum rmap_status describe(struct rmap_h5 *h5, hid_t object, struct rmap_h5_unit unit,
                                 const char *description, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(put_text(h5, object, "units", unit.name, err));
    RMAP_TRY(put_numbers(h5, object, "unitSI", RMAP_F64, 1, &unit.si, err));
    RMAP_TRY(put_numbers(h5, object, "unitDimension", RMAP_F64, 7, unit.dimension, err));
    RMAP_TRY(put_text(h5, object, "description", description, err));
out:
    return st;
}

/* The object at a path is looked for once, whatever is put on it. */
static enum rmap_status close_object(struct rmap_h5 *h5, hid_t object, const char *path,
                                     enum rmap_status st, struct rmap_error *err)
{
    if (object >= 0 && !h5->failed && H5Oclose(object) < 0 && st == RMAP_OK)
        st = rmap_h5_fail(h5, path, err);
    return st;
}

enum rmap_status rmap_h5_put_text(struct rmap_h5 *h5, const char *path, const char *name,
                                  const char *text, struct rmap_error *err)
{
    enum rmap_status st = rmap_h5_check_alive(h5, err);
    if (st != RMAP_OK)
        return st;
    hid_t object = H5Oopen(h5->file, path, H5P_DEFAULT);
    return close_object(h5, object, path, put_text(h5, object, name, text, err), err);
}

enum rmap_status rmap_h5_put(struct rmap_h5 *h5, const char *path, const char *name,
                             enum rmap_element element, size_t n, const void *data,
                             struct rmap_error *err)
{
    enum rmap_status st = rmap_h5_check_alive(h5, err);
    if (st != RMAP_OK)
        return st;
    hid_t object = H5Oopen(h5->file, path, H5P_DEFAULT);
    return close_object(h5, object, path, put_numbers(h5, object, name, element, n, data, err),
                        err);
}

enum rmap_status rmap_h5_describe(struct rmap_h5 *h5, const char *path, struct rmap_h5_unit unit,
                                  const char *description, struct rmap_error *err)
{
    enum rmap_status st = rmap_h5_check_alive(h5, err);
    if (st != RMAP_OK)
        return st;
    hid_t object = H5Oopen(h5->file, path, H5P_DEFAULT);
    return close_object(h5, object, path, describe(h5, object, unit, description, err), err);
}

/* Elements of other sizes than a number's (texts) go through HDF5's own filters. */
static bool is_number(size_t nbytes)
{
    return nbytes == 1 || nbytes == 2 || nbytes == 4 || nbytes == 8;
}

static enum rmap_status write_elements(struct rmap_h5 *h5, hid_t set, const char *path, hid_t type,
                                       const struct rmap_h5_tiles *tiles, const void *data,
                                       struct rmap_error *err)
{
    bool written = false;
    if (tiles->worthwhile && is_number(tiles->element_nbytes)) {
        enum rmap_status st = rmap_h5_write_tiles(set, tiles, data, &written, err);
        if (st != RMAP_OK)
            return st;
    } else {
        written = H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0;
    }
    return written ? RMAP_OK : rmap_h5_fail(h5, path, err);
}

/* What every dataset is given. */
struct table {
    const char *path, *description;
    struct rmap_h5_unit unit;
    hid_t type;
    int rank;
    const hsize_t *dims;
};

static enum rmap_status describe_table(struct rmap_h5 *h5, hid_t set, const struct table *table,
                                       size_t cell, const void *data, struct rmap_error *err)
{
    size_t nbytes = cell;
    for (int k = 0; k < table->rank; k++)
        nbytes *= (size_t)table->dims[k];
    uint64_t sum = rmap_checksum(data, nbytes);
    enum rmap_status st = describe(h5, set, table->unit, table->description, err);
    return st == RMAP_OK ? put_numbers(h5, set, "checksum", RMAP_U64, 1, &sum, err) : st;
}

static enum rmap_status write_table(struct rmap_h5 *h5, const struct table *table, const void *data,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    hid_t space = H5Screate_simple(table->rank, table->dims, NULL),
          create = H5Pcreate(H5P_DATASET_CREATE);
    hid_t set = H5I_INVALID_HID;
    struct rmap_h5_tiles tiles;
    hsize_t n = 1;
    for (int k = 0; k < table->rank; k++)
        n *= table->dims[k];
    if (table->type < 0 || space < 0 || create < 0 || H5Pset_obj_track_times(create, false) < 0 ||
        !rmap_h5_tile(table->rank, table->dims, H5Tget_size(table->type), &tiles) ||
        (tiles.worthwhile && !rmap_h5_set_deflate(create, &tiles)) ||
        (set = H5Dcreate2(h5->file, table->path, table->type, space, H5P_DEFAULT, create,
                          H5P_DEFAULT)) < 0)
        st = rmap_h5_fail(h5, table->path, err);
    else if (n > 0)
        st = write_elements(h5, set, table->path, table->type, &tiles, data, err);
    if (st == RMAP_OK)
        st = describe_table(h5, set, table, tiles.element_nbytes, data, err);
    if (set >= 0 && !h5->failed && H5Dclose(set) < 0)
        st = rmap_h5_fail(h5, table->path, err);
    (void)H5Sclose(space);
    (void)H5Pclose(create);
    return st;
}

enum rmap_status rmap_h5_write(struct rmap_h5 *h5, const struct rmap_h5_array *array,
                               const void *data, struct rmap_error *err)
{
    enum rmap_status st = rmap_h5_check_alive(h5, err);
    if (st != RMAP_OK)
        return st;
    const struct table table = {.path = array->path,
                                .description = array->description,
                                .unit = array->unit,
                                .type = rmap_h5_type(array->element),
                                .rank = array->rank,
                                .dims = array->dims};
    return write_table(h5, &table, data, err);
}

enum rmap_status rmap_h5_write_names(struct rmap_h5 *h5, const char *path, const char *const *name,
                                     size_t n, const char *description, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t width = 1;
    char *text = NULL;
    hid_t type = H5I_INVALID_HID;
    hsize_t dims = n;
    RMAP_TRY(rmap_h5_check_alive(h5, err));
    for (size_t i = 0; i < n; i++)
        if (name[i] && strlen(name[i]) > width)
            width = strlen(name[i]);
    text = rmap_alloc(n, width);
    if (!text) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the names in %s", path);
        goto out;
    }
    for (size_t i = 0; i < n; i++)
        if (name[i])
            memcpy(text + i * width, name[i], strlen(name[i]));
    type = string_type(width);
    const struct table table = {.path = path,
                                .description = description,
                                .unit = rmap_h5_unit_of(RMAP_UNIT_ONE, NULL, 1),
                                .type = type,
                                .rank = 1,
                                .dims = &dims};
    RMAP_TRY(write_table(h5, &table, text, err));
out:
    if (type >= 0)
        (void)H5Tclose(type);
    rmap_free(text);
    return st;
}

enum rmap_status rmap_h5_write_fields(struct rmap_h5 *h5, const struct rmap_h5_field *field,
                                      size_t n_field, const void *row, size_t n, size_t row_nbytes,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t f = 0; f < n_field; f++) {
        size_t cell = field[f].width * rmap_element_nbytes(field[f].element);
        char *column = rmap_alloc(n, cell);
        if (!column)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %s", field[f].path);
        for (size_t i = 0; i < n; i++)
            memcpy(column + i * cell, (const char *)row + i * row_nbytes + field[f].offset, cell);
        struct rmap_h5_array array = {field[f].path,
                                      field[f].element,
                                      field[f].width == 1 ? 1 : 2,
                                      {n, field[f].width},
                                      rmap_h5_unit_of(RMAP_UNIT_ONE, NULL, 1),
                                      field[f].description};
        st = rmap_h5_write(h5, &array, column, err);
        rmap_free(column);
        if (st != RMAP_OK)
            return st;
    }
    return st;
}
