/* SPDX-License-Identifier: MIT
 *
 * Numbers over the cells of a grid as an HDF5 file of their own: a detector's picture.
 */
#include "io/hdf5/grid_h5.h"

#include <stdio.h>

#include "io/file/whole_file.h"
#include "io/hdf5/h5.h"
#include "io/hdf5/h5_write.h"

static enum rmap_status write_array(struct rmap_h5 *h5, const struct rmap_grid_array *array,
                                    struct rmap_error *err)
{
    char path[80];
    (void)snprintf(path, sizeof path, "/%.70s", array->name);
    struct rmap_h5_array as = {.path = path,
                               .element = RMAP_F64,
                               .rank = array->rank,
                               .unit = rmap_h5_unit_named(array->unit),
                               .description = array->description};
    for (int k = 0; k < array->rank; k++)
        as.dims[k] = array->dims[k];
    return rmap_h5_write(h5, &as, array->data, err);
}

enum rmap_status rmap_grid_h5_write(const char *path, const struct rmap_grid_array *array,
                                    size_t n_array, const struct rmap_grid_text *text,
                                    size_t n_text, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_whole_file whole = {0};
    struct rmap_h5 h5 = {0};
    RMAP_TRY(rmap_whole_file_name(&whole, path, err));
    RMAP_TRY(rmap_h5_create(&h5, whole.temporary, err));
    for (size_t i = 0; i < n_text; i++)
        if (text[i].text)
            RMAP_TRY(rmap_h5_put_text(&h5, "/", text[i].name, text[i].text, err));
    for (size_t i = 0; i < n_array; i++)
        RMAP_TRY(write_array(&h5, &array[i], err));
    RMAP_TRY(rmap_h5_close(&h5, err));
    st = rmap_whole_file_finish(&whole, err);
out:
    if (st != RMAP_OK)
        rmap_error_context(err, "cannot write '%s'", path);
    rmap_h5_drop(&h5);
    rmap_whole_file_fini(&whole);
    return st;
}
