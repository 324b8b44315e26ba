/* SPDX-License-Identifier: MIT
 *
 * A portion as one block of bytes that travels between ranks of one program.
 */
#include "mpi/parallel/parcel.h"

#include <string.h>

#include "base/alloc.h"

struct header {
    uint64_t first_ray, n_row[RMAP_TABLE_COUNT], n_channel;
};

/* Columns begin at multiples of 8 bytes. */
static size_t column_nbytes(const struct rmap_portion *portion, enum rmap_column column)
{
    size_t rows = portion->n_row[rmap_column_info(column)->table];
    return (rows * rmap_portion_row_nbytes(portion, column) + 7) / 8 * 8;
}

static size_t parcel_nbytes(const struct rmap_portion *portion)
{
    size_t nbytes = sizeof(struct header);
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        nbytes += column_nbytes(portion, (enum rmap_column)c);
    return nbytes;
}

enum rmap_status rmap_parcel_create(size_t nbytes, struct rmap_parcel **parcel_ret,
                                    struct rmap_error *err)
{
    struct rmap_parcel *parcel = rmap_alloc(1, sizeof *parcel);
    if (parcel)
        parcel->bytes = rmap_alloc(nbytes, 1);
    if (!parcel || !parcel->bytes) {
        rmap_free(parcel);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a block of %zu bytes", nbytes);
    }
    parcel->nbytes = nbytes;
    *parcel_ret = parcel;
    return RMAP_OK;
}

void rmap_parcel_destroy(struct rmap_parcel *parcel)
{
    if (!parcel)
        return;
    rmap_free(parcel->bytes);
    rmap_free(parcel);
}

enum rmap_status rmap_parcel_pack(const struct rmap_portion *portion,
                                  struct rmap_parcel **parcel_ret, struct rmap_error *err)
{
    struct rmap_parcel *parcel = NULL;
    enum rmap_status st = rmap_parcel_create(parcel_nbytes(portion), &parcel, err);
    if (st != RMAP_OK)
        return st;
    struct header header = {.first_ray = portion->first_ray,
                            .n_channel = (uint64_t)portion->n_channel};
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        header.n_row[t] = portion->n_row[t];
    memcpy(parcel->bytes, &header, sizeof header);
    size_t at = sizeof header;
    for (int i = 0; i < RMAP_COLUMN_COUNT; i++) {
        enum rmap_column c = (enum rmap_column)i;
        size_t rows = portion->n_row[rmap_column_info(c)->table];
        if (rows > 0)
            memcpy(parcel->bytes + at, rmap_portion_column(portion, c),
                   rows * rmap_portion_row_nbytes(portion, c));
        at += column_nbytes(portion, c);
    }
    *parcel_ret = parcel;
    return RMAP_OK;
}

enum rmap_status rmap_parcel_view(const struct rmap_parcel *parcel, struct rmap_portion *view,
                                  struct rmap_error *err)
{
    struct header header = {0};
    *view = (struct rmap_portion){0};
    bool fits = parcel->nbytes >= sizeof header;
    if (fits)
        memcpy(&header, parcel->bytes, sizeof header);
    fits = fits && header.n_channel >= 1 && header.n_channel <= UINT16_MAX;
    for (int t = 0; t < RMAP_TABLE_COUNT; t++) {
        fits = fits && header.n_row[t] <= parcel->nbytes;
        view->n_row[t] = (size_t)header.n_row[t];
    }
    view->first_ray = header.first_ray;
    view->n_channel = fits ? (int)header.n_channel : 1;
    if (!fits || parcel_nbytes(view) != parcel->nbytes)
        return rmap_error_set(err, RMAP_INTERNAL, "a block from another rank is torn");
    size_t at = sizeof header;
    for (int i = 0; i < RMAP_COLUMN_COUNT; i++) {
        enum rmap_column c = (enum rmap_column)i;
        void *start = parcel->bytes + at;
        memcpy((void *)rmap_portion_column_address(view, c), &start, sizeof start);
        at += column_nbytes(view, c);
    }
    return RMAP_OK;
}
