/* SPDX-License-Identifier: MIT
 *
 * /portion of a piece or of an index, with the last ids that files of picked rays have besides.
 */
#include "io/map/portion_rows.h"

#include "base/alloc.h"
#include "io/hdf5/h5_read.h"
#include "io/hdf5/h5_write.h"

enum rmap_status rmap_portion_rows_read(struct rmap_h5 *h5, struct rmap_field_table fields,
                                        struct rmap_portion_info **portion_ret, size_t *n_ret,
                                        struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_field_table more = rmap_portion_fields_picked();
    struct rmap_portion_info *portion;
    void *rows = NULL, *last = NULL;
    size_t n = 0, n_last = 0;
    RMAP_TRY(rmap_h5_read_fields(h5, fields.field, fields.n, sizeof *portion, &rows, &n, err));
    portion = rows;
    if (rmap_h5_has(h5, more.field->path)) {
        RMAP_TRY(rmap_h5_read_fields(h5, more.field, more.n, sizeof *portion, &last, &n_last, err));
        if (n_last != n)
            RMAP_TRY(rmap_error_set(err, RMAP_FORMAT, "%s: %s has other rows than /portion",
                                    h5->path, more.field->path));
    }
    for (size_t i = 0; i < n_last; i++) {
        portion[i].last_ray = ((struct rmap_portion_info *)last)[i].last_ray;
        uint64_t span = portion[i].last_ray - portion[i].first_ray;
        if (portion[i].last_ray < portion[i].first_ray || portion[i].last_ray == UINT64_MAX ||
            span < portion[i].n_row[RMAP_TABLE_RAY] - 1)
            RMAP_TRY(rmap_error_set(err, RMAP_FORMAT, "%s: %s: portion %zu has more rays than ids",
                                    h5->path, more.field->path, i));
    }
    *portion_ret = portion;
    *n_ret = n;
    rows = NULL;
out:
    rmap_free(rows);
    rmap_free(last);
    return st;
}

enum rmap_status rmap_portion_rows_write(struct rmap_h5 *h5, struct rmap_field_table fields,
                                         const struct rmap_portion_info *portion, size_t n,
                                         bool picked, struct rmap_error *err)
{
    struct rmap_field_table more = rmap_portion_fields_picked();
    enum rmap_status st =
        rmap_h5_write_fields(h5, fields.field, fields.n, portion, n, sizeof *portion, err);
    if (st == RMAP_OK && picked)
        st = rmap_h5_write_fields(h5, more.field, more.n, portion, n, sizeof *portion, err);
    return st;
}
