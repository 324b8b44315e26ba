/* SPDX-License-Identifier: MIT
 *
 * Tables of some size are deflated and inflated by our own codec in place of HDF5's filter, which
 * took most of the time of writing and of opening an index.
 */
#include "io/hdf5/h5_deflate.h"

#include <string.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "io/codec/shuffle.h"
#include "io/codec/zlib_stream.h"

/* What readers are told; any zlib level reads alike. */
#define DECLARED_LEVEL 1

bool rmap_h5_tile(int rank, const hsize_t *dims, size_t element_nbytes, struct rmap_h5_tiles *tiles)
{
    const hsize_t worthwhile = 4096, chunk_nbytes = 1 << 20;
    hsize_t nbytes = element_nbytes;
    *tiles = (struct rmap_h5_tiles){.rank = rank, .element_nbytes = element_nbytes};
    if (rank < 1 || rank > RMAP_H5_RANK_MAX || element_nbytes == 0)
        return false;
    for (int k = rank - 1; k >= 0; k--) {
        if (dims[k] == 0)
            return true;
        hsize_t room = chunk_nbytes / nbytes;
        tiles->dims[k] = dims[k];
        tiles->chunk[k] = dims[k] < room ? dims[k] : room > 0 ? room : 1;
        nbytes *= tiles->chunk[k];
    }
    tiles->worthwhile = nbytes >= worthwhile;
    return true;
}

bool rmap_h5_set_deflate(hid_t create, const struct rmap_h5_tiles *tiles)
{
    return H5Pset_chunk(create, tiles->rank, tiles->chunk) >= 0 && H5Pset_shuffle(create) >= 0 &&
           H5Pset_deflate(create, DECLARED_LEVEL) >= 0;
}

void rmap_h5_scratch_fini(struct rmap_h5_scratch *scratch)
{
    rmap_deflater_destroy(scratch->deflater);
    rmap_free(scratch->raw);
    rmap_free(scratch->plane);
    rmap_free(scratch->stored);
}

enum rmap_status rmap_h5_scratch_init(struct rmap_h5_scratch *scratch, size_t n,
                                      size_t element_nbytes, struct rmap_error *err)
{
    scratch->n = n;
    scratch->element_nbytes = element_nbytes;
    enum rmap_status st = rmap_deflater_create(false, &scratch->deflater, err);
    if (st != RMAP_OK)
        return st;
    scratch->raw = rmap_alloc(n, element_nbytes);
    scratch->plane = rmap_alloc(n, element_nbytes);
    scratch->stored = rmap_alloc(rmap_deflate_bound(n * element_nbytes), 1);
    if (!scratch->raw || !scratch->plane || !scratch->stored)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a table");
    return RMAP_OK;
}

/* The dimension along which the table is cut; those before it have chunks of 1. */
static int cut_dimension(const struct rmap_h5_tiles *tiles)
{
    int k = tiles->rank - 1;
    while (k > 0 && tiles->chunk[k] == tiles->dims[k])
        k--;
    return k;
}

bool rmap_h5_write_chunk(hid_t set, struct rmap_h5_scratch *scratch, const void *first, size_t n,
                         const hsize_t *at)
{
    size_t cell = scratch->element_nbytes, all = scratch->n;
    memcpy(scratch->raw, first, n * cell); /* aligned */
    memset(scratch->raw + n * cell, 0, (all - n) * cell);
    rmap_shuffle(scratch->raw, all, cell, scratch->plane, all);
    size_t nbytes = rmap_deflate(scratch->deflater, scratch->plane, all * cell, scratch->stored);
    return H5Dwrite_chunk(set, H5P_DEFAULT, 0, at, nbytes, scratch->stored) >= 0;
}

static bool write_all(hid_t set, struct rmap_h5_scratch *scratch, const struct rmap_h5_tiles *tiles,
                      const uint8_t *data)
{
    int cut = cut_dimension(tiles);
    size_t inner = 1, n_outer = 1;
    for (int k = 0; k < cut; k++)
        n_outer *= (size_t)tiles->dims[k];
    for (int k = cut + 1; k < tiles->rank; k++)
        inner *= (size_t)tiles->dims[k];
    for (size_t o = 0; o < n_outer; o++) {
        hsize_t at[RMAP_H5_RANK_MAX] = {0};
        size_t rest = o;
        for (int k = cut - 1; k >= 0; k--) {
            at[k] = rest % tiles->dims[k];
            rest /= tiles->dims[k];
        }
        for (at[cut] = 0; at[cut] < tiles->dims[cut]; at[cut] += tiles->chunk[cut]) {
            hsize_t left = tiles->dims[cut] - at[cut];
            size_t n = (size_t)(left < tiles->chunk[cut] ? left : tiles->chunk[cut]);
            size_t first = (o * (size_t)tiles->dims[cut] + (size_t)at[cut]) * inner;
            if (!rmap_h5_write_chunk(set, scratch, data + first * tiles->element_nbytes, n * inner,
                                     at))
                return false;
        }
    }
    return true;
}

enum rmap_status rmap_h5_write_tiles(hid_t set, const struct rmap_h5_tiles *tiles, const void *data,
                                     bool *written_ret, struct rmap_error *err)
{
    struct rmap_h5_scratch scratch = {NULL};
    size_t all = 1;
    *written_ret = false;
    for (int k = 0; k < tiles->rank; k++)
        all *= (size_t)tiles->chunk[k];
    enum rmap_status st = rmap_h5_scratch_init(&scratch, all, tiles->element_nbytes, err);
    if (st == RMAP_OK)
        *written_ret = write_all(set, &scratch, tiles, data);
    rmap_h5_scratch_fini(&scratch);
    return st;
}

/* ---- reading ---- */

static bool has_filter(hid_t create, unsigned index, H5Z_filter_t wanted)
{
    unsigned flags, value[8], config;
    size_t n = sizeof value / sizeof *value;
    return H5Pget_filter2(create, index, &flags, &n, value, 0, NULL, &config) == wanted;
}

/* Whether the table has the filters above, and chunks of whole rows: *rows_ret of them each. */
static bool has_tiles(hid_t set, int rank, const hsize_t *dims, hsize_t *rows_ret)
{
    hsize_t chunk[RMAP_H5_RANK_MAX] = {0};
    hid_t create = H5Dget_create_plist(set);
    bool has = create >= 0 && H5Pget_layout(create) == H5D_CHUNKED &&
               H5Pget_chunk(create, RMAP_H5_RANK_MAX, chunk) == rank &&
               H5Pget_nfilters(create) == 2 && has_filter(create, 0, H5Z_FILTER_SHUFFLE) &&
               has_filter(create, 1, H5Z_FILTER_DEFLATE) && chunk[0] <= dims[0];
    for (int k = 1; has && k < rank; k++)
        has = chunk[k] == dims[k];
    if (create >= 0)
        (void)H5Pclose(create);
    *rows_ret = chunk[0];
    return has && chunk[0] > 0;
}

/* What reading a chunk takes. */
struct tile_reader {
    hid_t set;
    struct rmap_inflater *inflater;
    uint8_t *stored, *plane;
    hsize_t cap; /* bytes of `stored`: of all chunks */
    size_t n, element_nbytes;
};

/* The chunk at `at`, as planes. The table has a checksum of its own. */
static bool read_planes(struct tile_reader *self, const hsize_t *at)
{
    hsize_t n = 0;
    uint32_t mask = 0;
    return H5Dget_chunk_storage_size(self->set, at, &n) >= 0 && n <= self->cap &&
           H5Dread_chunk(self->set, H5P_DEFAULT, at, &mask, self->stored) >= 0 && mask == 0 &&
           rmap_inflate(self->inflater, self->stored, (size_t)n, self->plane,
                        self->n * self->element_nbytes);
}

bool rmap_h5_read_tiles(hid_t set, int rank, const hsize_t *dims, size_t element_nbytes, void *data,
                        size_t step, uint64_t *sum_ret)
{
    struct tile_reader self = {
        .set = set, .element_nbytes = element_nbytes, .cap = H5Dget_storage_size(set)};
    hsize_t at[RMAP_H5_RANK_MAX] = {0}, rows;
    size_t row = 1;
    if (!has_tiles(set, rank, dims, &rows))
        return false;
    for (int k = 1; k < rank; k++)
        row *= (size_t)dims[k];
    const size_t row_nbytes = row * element_nbytes;
    self.n = (size_t)rows * row;
    self.stored = rmap_alloc_unset((size_t)self.cap + RMAP_INFLATE_SLACK, 1);
    self.plane = rmap_alloc_unset(self.n, element_nbytes);
    uint8_t *packed = step == row_nbytes ? NULL : rmap_alloc_unset(self.n, element_nbytes);
    XXH3_state_t *sum = XXH3_createState();
    bool good = self.stored && self.plane && (packed || step == row_nbytes) && sum &&
                XXH3_64bits_reset(sum) == XXH_OK &&
                rmap_inflater_create(&self.inflater, NULL) == RMAP_OK;
    for (; good && at[0] < dims[0]; at[0] += rows) {
        const size_t n = (size_t)(dims[0] - at[0] < rows ? dims[0] - at[0] : rows);
        uint8_t *to = (uint8_t *)data + at[0] * step, *run = packed ? packed : to;
        good = read_planes(&self, at);
        if (!good)
            break;
        rmap_unshuffle(self.plane, self.n, 0, n * row, element_nbytes, run);
        (void)XXH3_64bits_update(sum, run, n * row_nbytes);
        for (size_t i = 0; packed && i < n; i++)
            memcpy(to + i * step, packed + i * row_nbytes, row_nbytes);
    }
    if (good)
        *sum_ret = XXH3_64bits_digest(sum);
    (void)XXH3_freeState(sum);
    rmap_inflater_destroy(self.inflater);
    rmap_free(packed);
    rmap_free(self.plane);
    rmap_free(self.stored);
    return good;
}
