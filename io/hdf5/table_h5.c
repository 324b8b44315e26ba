/* SPDX-License-Identifier: MIT
 *
 * Tables of numbers, column by column, as an HDF5 file of their own.
 */
#include "io/hdf5/table_h5.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "io/file/seal.h"
#include "io/file/whole_file.h"
#include "io/hdf5/h5.h"
#include "io/hdf5/h5_deflate.h"
#include "io/hdf5/h5_write.h"

/* Of a chunk, which is written in one go. */
enum { ROWS = 16384, PATH_NBYTES = 80 };

struct column {
    char path[PATH_NBYTES];
    hid_t set; /* H5I_INVALID_HID: closed */
    size_t element_nbytes;
    uint8_t *waiting; /* [ROWS] elements, n_waiting of them in use */
    size_t n_waiting;
    hsize_t n_written;
};

struct rmap_table_h5 {
    struct rmap_whole_file whole;
    struct rmap_h5 h5;
    size_t n;
    struct column *column;
};

static enum rmap_status create_set(struct rmap_h5 *h5, const struct rmap_table_h5_column *given,
                                   struct column *column, struct rmap_error *err)
{
    static const hsize_t none = 0, unlimited = H5S_UNLIMITED;
    enum rmap_status st = RMAP_OK;
    const struct rmap_h5_tiles tiles = {
        .rank = 1, .element_nbytes = column->element_nbytes, .chunk = {ROWS}};
    hid_t create = H5Pcreate(H5P_DATASET_CREATE), space = H5Screate_simple(1, &none, &unlimited);
    if (create < 0 || space < 0 || H5Pset_obj_track_times(create, false) < 0 ||
        !rmap_h5_set_deflate(create, &tiles) ||
        (column->set = H5Dcreate2(h5->file, column->path, rmap_h5_type(given->element), space,
                                  H5P_DEFAULT, create, H5P_DEFAULT)) < 0)
        st = rmap_h5_fail(h5, column->path, err);
    (void)H5Sclose(space);
    (void)H5Pclose(create);
    return st == RMAP_OK ? rmap_h5_describe(h5, column->path, rmap_h5_unit_named(given->unit),
                                            given->description, err)
                         : st;
}

static enum rmap_status create_columns(struct rmap_table_h5 *self,
                                       const struct rmap_table_h5_column *given, size_t n,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (; self->n < n; self->n++)
        self->column[self->n] = (struct column){
            .set = H5I_INVALID_HID, .element_nbytes = rmap_element_nbytes(given[self->n].element)};
    for (size_t c = 0; c < n; c++) {
        struct column *column = &self->column[c];
        if (c == 0 || strcmp(given[c].group, given[c - 1].group) != 0) {
            (void)snprintf(column->path, PATH_NBYTES, "/%s", given[c].group);
            RMAP_TRY(rmap_h5_group(&self->h5, column->path, err));
        }
        (void)snprintf(column->path, PATH_NBYTES, "/%s/%s", given[c].group, given[c].name);
        column->waiting = rmap_alloc(ROWS, column->element_nbytes);
        if (!column->waiting)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %s", column->path);
        RMAP_TRY(create_set(&self->h5, &given[c], column, err));
    }
out:
    return st;
}

enum rmap_status rmap_table_h5_begin(const char *path, const struct rmap_table_h5_column *column,
                                     size_t n, struct rmap_table_h5 **table_ret,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_table_h5 *self = rmap_alloc(1, sizeof *self);
    if (self)
        self->column = rmap_alloc(n + 1, sizeof *self->column);
    if (!self || !self->column)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for tables"));
    RMAP_TRY(rmap_whole_file_name(&self->whole, path, err));
    RMAP_TRY(rmap_h5_create(&self->h5, self->whole.temporary, err));
    RMAP_TRY(rmap_h5_group(&self->h5, "/name", err));
    RMAP_TRY(create_columns(self, column, n, err));
    *table_ret = self;
    self = NULL;
out:
    if (st != RMAP_OK)
        rmap_error_context(err, "cannot write '%s'", path);
    rmap_table_h5_destroy(self);
    return st;
}

enum rmap_status rmap_table_h5_put_text(struct rmap_table_h5 *self, const char *name,
                                        const char *text, struct rmap_error *err)
{
    return rmap_h5_put_text(&self->h5, "/", name, text, err);
}

enum rmap_status rmap_table_h5_put_number(struct rmap_table_h5 *self, const char *name,
                                          enum rmap_element element, const void *value,
                                          struct rmap_error *err)
{
    return rmap_h5_put(&self->h5, "/", name, element, 1, value, err);
}

enum rmap_status rmap_table_h5_put_names(struct rmap_table_h5 *self, const char *name,
                                         const char *const *text, size_t n, const char *description,
                                         struct rmap_error *err)
{
    char path[PATH_NBYTES];
    (void)snprintf(path, sizeof path, "/name/%s", name);
    return rmap_h5_write_names(&self->h5, path, text, n, description, err);
}

static enum rmap_status write_waiting(struct rmap_table_h5 *self, struct column *column,
                                      struct rmap_error *err)
{
    struct rmap_h5 *h5 = &self->h5;
    struct rmap_h5_scratch scratch = {NULL};
    const hsize_t at = column->n_written, extent = at + column->n_waiting;
    enum rmap_status st = rmap_h5_check_alive(h5, err);
    RMAP_TRY(st);
    RMAP_TRY(rmap_h5_scratch_init(&scratch, ROWS, column->element_nbytes, err));
    if (H5Dset_extent(column->set, &extent) < 0 ||
        !rmap_h5_write_chunk(column->set, &scratch, column->waiting, column->n_waiting, &at))
        RMAP_TRY(rmap_h5_fail(h5, column->path, err));
    column->n_written = extent;
    column->n_waiting = 0;
out:
    if (st != RMAP_OK)
        rmap_error_context(err, "cannot write '%s'", self->whole.path);
    rmap_h5_scratch_fini(&scratch);
    return st;
}

enum rmap_status rmap_table_h5_add(struct rmap_table_h5 *self, size_t c, const void *element,
                                   struct rmap_error *err)
{
    struct column *column = &self->column[c];
    memcpy(column->waiting + column->n_waiting * column->element_nbytes, element,
           column->element_nbytes);
    column->n_waiting++;
    return column->n_waiting < ROWS ? RMAP_OK : write_waiting(self, column, err);
}

struct rmap_h5 *rmap_table_h5_file(struct rmap_table_h5 *self)
{
    return &self->h5;
}

enum rmap_status rmap_table_h5_finish(struct rmap_table_h5 *self, bool seals,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t c = 0; c < self->n; c++) {
        struct column *column = &self->column[c];
        if (column->n_waiting > 0)
            RMAP_TRY(write_waiting(self, column, err));
        if (H5Dclose(column->set) < 0)
            RMAP_TRY(rmap_h5_fail(&self->h5, column->path, err));
        column->set = H5I_INVALID_HID;
    }
    RMAP_TRY(rmap_h5_close(&self->h5, err));
    if (seals)
        RMAP_TRY(rmap_seal_write(self->whole.temporary, NULL, 0, err));
    st = rmap_whole_file_finish(&self->whole, err);
out:
    return st;
}

void rmap_table_h5_destroy(struct rmap_table_h5 *self)
{
    if (!self)
        return;
    for (size_t c = 0; c < self->n; c++) {
        if (self->column[c].set >= 0 && !self->h5.failed)
            (void)H5Dclose(self->column[c].set);
        rmap_free(self->column[c].waiting);
    }
    rmap_free(self->column);
    rmap_h5_drop(&self->h5);
    rmap_whole_file_fini(&self->whole);
    rmap_free(self);
}
