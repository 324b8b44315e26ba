/* SPDX-License-Identifier: MIT
 *
 * Tables of some size are deflated and inflated by our own codec in place of HDF5's filter, which
 * took most of the time of writing and of opening an index. Any HDF5 tool reads the result.
 */
#ifndef RMAP_H5_DEFLATE_H
#define RMAP_H5_DEFLATE_H

#include "io/hdf5/h5.h"

/* A table and the chunks that it is cut into: whole trailing dimensions, and as much of the one
 * before them as fits. */
struct rmap_h5_tiles {
    int rank;
    size_t element_nbytes;
    hsize_t dims[RMAP_H5_RANK_MAX], chunk[RMAP_H5_RANK_MAX];
    bool worthwhile; /* false: too small to be cut and deflated */
};

/* False for a rank or an element that no table has. */
bool rmap_h5_tile(int rank, const hsize_t *dims, size_t element_nbytes,
                  struct rmap_h5_tiles *tiles);

/* Filters for a table that is worth them. */
bool rmap_h5_set_deflate(hid_t create, const struct rmap_h5_tiles *tiles);

/* Writes all of the table into an empty dataset with those filters. RMAP_SYSTEM: memory; false in
 * *written_ret, with HDF5's error stack as it was left: HDF5 failed. */
enum rmap_status rmap_h5_write_tiles(hid_t set, const struct rmap_h5_tiles *tiles, const void *data,
                                     bool *written_ret, struct rmap_error *err) RMAP_MUST_USE;

/* Buffers for chunks of n elements; zeroed: none. */
struct rmap_h5_scratch {
    struct rmap_deflater *deflater;
    uint8_t *raw, *plane, *stored;
    size_t n, element_nbytes;
};
enum rmap_status rmap_h5_scratch_init(struct rmap_h5_scratch *scratch, size_t n,
                                      size_t element_nbytes, struct rmap_error *err) RMAP_MUST_USE;
void rmap_h5_scratch_fini(struct rmap_h5_scratch *scratch);

/* `n` elements as the chunk at `at` of a dataset with those filters; what the chunk has beyond them
 * is 0. False: HDF5 failed. */
bool rmap_h5_write_chunk(hid_t set, struct rmap_h5_scratch *scratch, const void *first, size_t n,
                         const hsize_t *at);

/* Reads all of a table whose chunks are such and follow each other in its first dimension. data:
 * its rows, aligned for their elements, one every `step` bytes. *sum_ret: rmap_checksum of the rows
 * without what is between. False: it is no such table, or not whole; HDF5 is to read it, and will
 * say what is wrong. */
bool rmap_h5_read_tiles(hid_t set, int rank, const hsize_t *dims, size_t element_nbytes, void *data,
                        size_t step, uint64_t *sum_ret);

#endif
