/* SPDX-License-Identifier: MIT
 *
 * The view of all pieces as one, for people with h5py: virtual datasets in the index, one per
 * column, by relative file names.
 */
#include "io/write/map_view.h"
#include "io/hdf5/h5_write.h"

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

struct view {
    struct rmap_h5 *h5;
    const struct rmap_scene *scene; /* for units */
    const struct rmap_map_spaces *spaces;
    const struct rmap_map_content *content;
};

struct column_shape {
    const struct rmap_stream_info *stream;
    int rank;
    hsize_t width;
    int32_t mode; /* of colours; -1: any */
};

/* A piece of another colour space has no such colours. */
static bool holds(const struct view *view, const struct rmap_piece_info *piece,
                  const struct column_shape *shape)
{
    const struct rmap_map_space *space = &view->spaces->space[piece->space];
    return piece->stored_rows[shape->stream->table] > 0 &&
           (shape->mode < 0 ||
            (space->mode == shape->mode && (hsize_t)space->n_channel == shape->width));
}

static herr_t map_piece(hid_t create, hid_t space, const struct column_shape *shape, hsize_t first,
                        const struct rmap_piece_info *piece)
{
    const hsize_t start[2] = {first, 0},
                  count[2] = {piece->stored_rows[shape->stream->table], shape->width};
    hid_t source = H5Screate_simple(shape->rank, count, NULL);
    herr_t failed = source < 0 ||
                    H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, count, NULL) < 0 ||
                    H5Pset_virtual(create, space, piece->name, shape->stream->path, source) < 0;
    if (source >= 0)
        (void)H5Sclose(source);
    return failed ? -1 : 0;
}

static enum rmap_status write_stream(const struct view *view, const struct column_shape *shape,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_stream_info *info = shape->stream;
    const struct rmap_map_content *content = view->content;
    hsize_t dims[2] = {0, shape->width}, first = 0;
    for (size_t i = 0; i < content->n_piece; i++)
        dims[0] += content->piece[i].stored_rows[info->table];
    hid_t create = H5Pcreate(H5P_DATASET_CREATE), set = H5I_INVALID_HID;
    hid_t space = H5Screate_simple(shape->rank, dims, NULL);
    bool failed = create < 0 || space < 0 || H5Pset_obj_track_times(create, false) < 0 ||
                  set_fill(create, info->element) < 0;
    for (size_t i = 0; !failed && i < content->n_piece; i++) {
        if (holds(view, &content->piece[i], shape))
            failed = map_piece(create, space, shape, first, &content->piece[i]) < 0;
        first += content->piece[i].stored_rows[info->table];
    }
    if (!failed && dims[0] > 0)
        failed = H5Sselect_all(space) < 0;
    if (failed || (set = H5Dcreate2(view->h5->file, info->path, rmap_h5_type(info->element), space,
                                    H5P_DEFAULT, create, H5P_DEFAULT)) < 0)
        st = rmap_h5_fail(view->h5, info->path, err);
    (void)H5Dclose(set);
    (void)H5Sclose(space);
    (void)H5Pclose(create);
    if (st == RMAP_OK)
        st = rmap_h5_describe(view->h5, info->path,
                              rmap_h5_unit_of(info->unit, view->scene->unit, view->scene->unit_m),
                              info->description, err);
    return st;
}

/* Channels of the first space of a mode; 0: none has it. */
static int channels_of(const struct view *view, enum rmap_colour_mode mode)
{
    for (size_t i = 0; i < view->spaces->n; i++)
        if (view->spaces->space[i].mode == (int32_t)mode)
            return view->spaces->space[i].n_channel;
    return 0;
}

static enum rmap_status write_streams(const struct view *view, enum rmap_colour_mode mode,
                                      bool colours, struct rmap_error *err)
{
    const struct rmap_layout *layout = rmap_layout_of(RMAP_ENCODING_PLAIN, mode);
    int n_channel = channels_of(view, mode);
    int n_stream = rmap_layout_n_stream(layout, view->scene);
    enum rmap_status st = RMAP_OK;
    for (int s = 0; st == RMAP_OK && s < n_stream; s++) {
        const struct rmap_stream_info *info = &layout->stream[s];
        const struct column_shape shape = {.stream = info,
                                           .rank = info->width == 1 ? 1 : 2,
                                           .width = rmap_stream_width(info, n_channel),
                                           .mode = info->width == 0 ? (int32_t)mode : -1};
        if ((info->width == 0) == colours && shape.width > 0)
            st = write_stream(view, &shape, err);
    }
    return st;
}

static const char *why_none(const struct rmap_map_content *content)
{
    if (content->n_piece > RMAP_VIEW_PIECES_MAX)
        return "none: too many pieces; read the pieces in /piece one by one";
    for (size_t i = 0; i < content->n_piece; i++)
        if (content->piece[i].encoding != RMAP_ENCODING_PLAIN)
            return "none: pieces in the compact encoding do not store columns; "
                   "raymap convert MAP -o MAP2 --encoding plain makes a map that does";
    return NULL;
}

enum rmap_status rmap_map_view_write(struct rmap_h5 *h5, const struct rmap_scene *scene,
                                     const struct rmap_map_spaces *spaces,
                                     const struct rmap_map_content *content, struct rmap_error *err)
{
    const struct view view = {h5, scene, spaces, content};
    const struct rmap_layout *layout = rmap_layout_of(RMAP_ENCODING_PLAIN, RMAP_COLOUR_SPECTRAL);
    const char *none = why_none(content);
    enum rmap_status st = RMAP_OK;
    if (none)
        return rmap_h5_put_text(h5, "/", "view", none, err);
    bool curved = rmap_scene_keeps_curves(scene);
    for (int t = 0; t < rmap_layout_n_table(layout, scene); t++)
        RMAP_TRY(rmap_h5_group(h5, layout->table_path[t], err));
    RMAP_TRY(write_streams(&view, RMAP_COLOUR_SPECTRAL, false, err));
    RMAP_TRY(write_streams(&view, RMAP_COLOUR_SPECTRAL, true, err));
    RMAP_TRY(write_streams(&view, RMAP_COLOUR_RGB, true, err));
    RMAP_TRY(rmap_h5_put_text(h5, "/", "view",
                              curved ? "/ray, /segment, /registration, /curve: all pieces as one"
                                     : "/ray, /segment, /registration: all pieces as one",
                              err));
out:
    return st;
}
