/* SPDX-License-Identifier: MIT */
#include "io/map_view.h"

#include <math.h>

/* Marks rows of a missing piece: NaN, or the largest value of an unsigned and the least of a
 * signed type, which no column holds. */
static herr_t set_fill(hid_t create, enum rmap_element element)
{
    static const union {
        float f32;
        uint8_t u8;
        uint16_t u16;
        int16_t i16;
        uint32_t u32;
        int32_t i32;
        uint64_t u64;
    } fill[] = {[RMAP_U8] = {.u8 = UINT8_MAX},   [RMAP_U16] = {.u16 = UINT16_MAX},
                [RMAP_I16] = {.i16 = INT16_MIN}, [RMAP_U32] = {.u32 = UINT32_MAX},
                [RMAP_I32] = {.i32 = INT32_MIN}, [RMAP_U64] = {.u64 = UINT64_MAX},
                [RMAP_F32] = {.f32 = NAN}};
    static const double nan64 = NAN;
    hid_t type = rmap_h5_type(element);
    return H5Pset_fill_value(create, type,
                             element == RMAP_F64 ? (const void *)&nan64 : &fill[element]);
}

struct column_shape {
    const char *path;
    int table;
    int rank;
    hsize_t width;
};

static herr_t map_piece(hid_t create, hid_t space, const struct column_shape *shape, hsize_t first,
                        const struct rmap_piece_info *piece)
{
    const hsize_t start[2] = {first, 0}, count[2] = {piece->n_row[shape->table], shape->width};
    hid_t source = H5Screate_simple(shape->rank, count, NULL);
    herr_t failed = source < 0 ||
                    H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, count, NULL) < 0 ||
                    H5Pset_virtual(create, space, piece->name, shape->path, source) < 0;
    if (source >= 0)
        (void)H5Sclose(source);
    return failed ? -1 : 0;
}

static enum rmap_status write_stream(struct rmap_h5 *h5, const struct rmap_scene *scene,
                                     const struct rmap_stream_info *info,
                                     const struct rmap_piece_info *piece, size_t n_piece,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t width = rmap_stream_width(info, scene->channels.n);
    const struct column_shape shape = {info->path, info->table, info->width == 1 ? 1 : 2, width};
    hsize_t dims[2] = {0, width}, first = 0;
    for (size_t i = 0; i < n_piece; i++)
        dims[0] += piece[i].n_row[info->table];
    hid_t create = H5Pcreate(H5P_DATASET_CREATE), set = H5I_INVALID_HID;
    hid_t space = H5Screate_simple(shape.rank, dims, NULL);
    bool failed = create < 0 || space < 0 || H5Pset_obj_track_times(create, false) < 0 ||
                  set_fill(create, info->element) < 0;
    for (size_t i = 0; !failed && i < n_piece; i++) {
        if (piece[i].n_row[info->table] > 0)
            failed = map_piece(create, space, &shape, first, &piece[i]) < 0;
        first += piece[i].n_row[info->table];
    }
    if (!failed && dims[0] > 0)
        failed = H5Sselect_all(space) < 0;
    if (failed || (set = H5Dcreate2(h5->file, shape.path, rmap_h5_type(info->element), space,
                                    H5P_DEFAULT, create, H5P_DEFAULT)) < 0)
        st = rmap_h5_fail(h5, shape.path, err);
    (void)H5Dclose(set);
    (void)H5Sclose(space);
    (void)H5Pclose(create);
    if (st == RMAP_OK)
        st = rmap_h5_describe(h5, shape.path,
                              rmap_h5_unit_of(info->unit, scene->unit, scene->unit_m),
                              info->description, err);
    return st;
}

enum rmap_status rmap_map_view_write(struct rmap_h5 *h5, const struct rmap_scene *scene,
                                     const struct rmap_piece_info *piece, size_t n_piece,
                                     struct rmap_error *err)
{
    const struct rmap_layout *layout = rmap_layout_of(RMAP_ENCODING_PLAIN, scene->channels.mode);
    enum rmap_status st = RMAP_OK;
    if (n_piece > RMAP_VIEW_PIECES_MAX)
        return rmap_h5_put_text(h5, "/", "view",
                                "none: too many pieces; read the pieces in /piece one by one", err);
    for (int t = 0; t < layout->n_table; t++)
        RMAP_TRY(rmap_h5_group(h5, layout->table_path[t], err));
    for (int s = 0; s < layout->n_stream; s++)
        RMAP_TRY(write_stream(h5, scene, &layout->stream[s], piece, n_piece, err));
    RMAP_TRY(
        rmap_h5_put_text(h5, "/", "view", "/ray, /segment, /registration: all pieces as one", err));
out:
    return st;
}
