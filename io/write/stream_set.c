/* SPDX-License-Identifier: MIT
 *
 * The dataset of a stream in a file that is being written.
 */
#include "io/write/stream_set.h"

#include "io/codec/codec.h"
#include "io/hdf5/h5_write.h"

/* What readers are told of the stored streams; any zlib level reads alike. */
#define DECLARED_LEVEL 1

static hid_t stream_properties(int rank, size_t width)
{
    const hsize_t chunk[2] = {RMAP_CHUNK_ROWS, width};
    hid_t create = H5Pcreate(H5P_DATASET_CREATE);
    if (create >= 0 &&
        (H5Pset_obj_track_times(create, false) < 0 || H5Pset_chunk(create, rank, chunk) < 0 ||
         H5Pset_fill_time(create, H5D_FILL_TIME_NEVER) < 0 || H5Pset_shuffle(create) < 0 ||
         H5Pset_deflate(create, DECLARED_LEVEL) < 0 || H5Pset_fletcher32(create) < 0)) {
        (void)H5Pclose(create);
        create = H5I_INVALID_HID;
    }
    return create;
}

enum rmap_status rmap_stream_set_create(struct rmap_h5 *h5, const struct rmap_stream_info *info,
                                        const struct rmap_scene *scene, hid_t *set_ret,
                                        struct rmap_error *err)
{
    static const hsize_t unlimited[2] = {H5S_UNLIMITED, H5S_UNLIMITED};
    enum rmap_status st = RMAP_OK;
    size_t width = rmap_stream_width(info, scene->channels.n);
    int rank = info->width == 1 ? 1 : 2;
    const hsize_t dims[2] = {0, width}, most[2] = {unlimited[0], width};
    hid_t create = stream_properties(rank, width), space = H5Screate_simple(rank, dims, most);
    if (create < 0 || space < 0 ||
        (*set_ret = H5Dcreate2(h5->file, info->path, rmap_h5_type(info->element), space,
                               H5P_DEFAULT, create, H5P_DEFAULT)) < 0)
        st = rmap_h5_fail(h5, info->path, err);
    (void)H5Sclose(space);
    (void)H5Pclose(create);
    if (st == RMAP_OK)
        st = rmap_h5_describe(h5, info->path,
                              rmap_h5_unit_of(info->unit, scene->unit, scene->unit_m),
                              info->description, err);
    return st;
}

enum rmap_status rmap_stream_set_put(struct rmap_h5 *h5, hid_t set,
                                     const struct rmap_stream_info *info, int n_channel, int number,
                                     uint32_t index, uint64_t n_row, const uint8_t *stored,
                                     size_t nbytes, struct rmap_chunk_entry *entry,
                                     struct rmap_error *err)
{
    const hsize_t extent[2] = {n_row, rmap_stream_width(info, n_channel)};
    const hsize_t offset[2] = {(hsize_t)index * RMAP_CHUNK_ROWS, 0};
    hsize_t found_nbytes = 0;
    haddr_t address = 0;
    unsigned mask = 0;
    if (h5->failed)
        return rmap_error_set(err, RMAP_SYSTEM, "%s: an earlier write failed", h5->path);
    if (H5Dset_extent(set, extent) < 0 ||
        H5Dwrite_chunk(set, H5P_DEFAULT, 0, offset, nbytes, stored) < 0 ||
        H5Dget_chunk_info_by_coord(set, offset, &mask, &address, &found_nbytes) < 0)
        return rmap_h5_fail(h5, info->path, err);
    *entry = (struct rmap_chunk_entry){.offset = address,
                                       .checksum = rmap_checksum(stored, nbytes),
                                       .nbytes = (uint32_t)nbytes,
                                       .lead_planes = (uint16_t)rmap_element_nbytes(info->element),
                                       .index = index,
                                       .stream = (uint16_t)number};
    return RMAP_OK;
}
