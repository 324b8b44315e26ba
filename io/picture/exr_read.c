/* SPDX-License-Identifier: MIT
 *
 * OpenEXR pictures, through OpenEXRCore, out of memory.
 */
#include <openexr.h>
#include <stdbool.h>
#include <string.h>

#include "io/picture/picture.h"

struct source {
    const uint8_t *bytes;
    size_t nbytes;
};

static int64_t read_bytes(exr_const_context_t file, void *user, void *to, uint64_t nbytes,
                          uint64_t at, exr_stream_error_func_ptr_t report)
{
    const struct source *source = user;
    (void)file;
    (void)report;
    if (at > source->nbytes)
        return -1;
    const size_t left = source->nbytes - (size_t)at, n = nbytes < left ? (size_t)nbytes : left;
    memcpy(to, source->bytes + at, n);
    return (int64_t)n;
}

static int64_t tell_size(exr_const_context_t file, void *user)
{
    (void)file;
    return (int64_t)((const struct source *)user)->nbytes;
}

/* Codes say enough; without a reporter the library prints. */
static void report_nothing(exr_const_context_t file, exr_result_t code, const char *message)
{
    (void)file;
    (void)code;
    (void)message;
}

/* Numbers of the picture that a channel fills, from..to; none of another channel. */
static void numbers_of(const char *name, int *from, int *to)
{
    static const char letter[] = "RGB";
    *from = 0;
    *to = strcmp(name, "Y") == 0 ? 1 : 0;
    for (int k = 0; k < 3; k++)
        if (name[0] == letter[k] && !name[1]) {
            *from = k;
            *to = k + 1;
        }
}

/* *grey: one channel fills red alone. */
static enum rmap_status head(exr_const_context_t file, struct rmap_picture *picture, int32_t *top,
                             bool *grey, struct rmap_error *err)
{
    exr_storage_t storage;
    exr_attr_box2i_t box;
    const exr_attr_chlist_t *list = NULL;
    int filled = 0;
    *grey = false;
    if (exr_get_storage(file, 0, &storage) != EXR_ERR_SUCCESS ||
        exr_get_data_window(file, 0, &box) != EXR_ERR_SUCCESS ||
        exr_get_channels(file, 0, &list) != EXR_ERR_SUCCESS || !list)
        return rmap_error_set(err, RMAP_INPUT, "it is no whole OpenEXR picture");
    for (int c = 0; c < list->num_channels; c++) {
        int from, to;
        numbers_of(list->entries[c].name.str, &from, &to);
        filled += to - from;
        *grey = list->num_channels == 1 && to > from;
        if (to > from && (list->entries[c].x_sampling != 1 || list->entries[c].y_sampling != 1))
            filled = 100;
    }
    if (storage != EXR_STORAGE_SCANLINE || (filled != 3 && !*grey))
        return rmap_error_set(err, RMAP_INPUT,
                              "an OpenEXR picture of scan lines with channels R, G and B, or Y, is "
                              "read: save it so (without tiles, layers and coarser channels)");
    *top = box.min.y;
    return rmap_picture_init(picture, (uint64_t)((int64_t)box.max.x - box.min.x + 1),
                             (uint64_t)((int64_t)box.max.y - box.min.y + 1), err);
}

static exr_result_t read_chunk(exr_const_context_t file, exr_decode_pipeline_t *decoder,
                               const exr_chunk_info_t *chunk, struct rmap_picture *picture,
                               size_t row, bool first)
{
    exr_result_t code = first ? exr_decoding_initialize(file, 0, chunk, decoder)
                              : exr_decoding_update(file, 0, chunk, decoder);
    for (int16_t c = 0; code == EXR_ERR_SUCCESS && c < decoder->channel_count; c++) {
        exr_coding_channel_info_t *channel = &decoder->channels[c];
        int from, to;
        numbers_of(channel->channel_name, &from, &to);
        channel->user_bytes_per_element = sizeof(float);
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_pixel_stride = 3 * (int32_t)sizeof(float);
        channel->user_line_stride = 3 * (int32_t)sizeof(float) * (int32_t)picture->size[0];
        channel->decode_to_ptr =
            to > from ? (uint8_t *)(picture->rgb + 3 * row * picture->size[0] + (size_t)from)
                      : NULL;
    }
    if (code == EXR_ERR_SUCCESS && first)
        code = exr_decoding_choose_default_routines(file, 0, decoder);
    return code == EXR_ERR_SUCCESS ? exr_decoding_run(file, 0, decoder) : code;
}

static exr_result_t read_rows(exr_const_context_t file, int32_t top, struct rmap_picture *picture)
{
    exr_decode_pipeline_t decoder = EXR_DECODE_PIPELINE_INITIALIZER;
    int32_t step = 0;
    exr_result_t code = exr_get_scanlines_per_chunk(file, 0, &step);
    for (uint32_t y = 0; code == EXR_ERR_SUCCESS && y < picture->size[1]; y += (uint32_t)step) {
        exr_chunk_info_t chunk;
        code = exr_read_scanline_chunk_info(file, 0, top + (int32_t)y, &chunk);
        if (code == EXR_ERR_SUCCESS)
            code = read_chunk(file, &decoder, &chunk, picture, y, y == 0);
    }
    (void)exr_decoding_destroy(file, &decoder);
    return code;
}

enum rmap_status rmap_picture_exr(const uint8_t *bytes, size_t nbytes, struct rmap_picture *picture,
                                  struct rmap_error *err)
{
    struct source source = {bytes, nbytes};
    exr_context_initializer_t options = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_context_t file = NULL;
    int32_t top = 0;
    bool grey = false;
    options.error_handler_fn = report_nothing;
    options.read_fn = read_bytes;
    options.size_fn = tell_size;
    options.user_data = &source;
    exr_result_t code = exr_start_read(&file, "picture", &options);
    if (code != EXR_ERR_SUCCESS)
        return rmap_error_set(err, RMAP_INPUT, "it is no whole OpenEXR picture: %s",
                              exr_get_default_error_message(code));
    enum rmap_status st = head(file, picture, &top, &grey, err);
    if (st == RMAP_OK && (code = read_rows(file, top, picture)) != EXR_ERR_SUCCESS)
        st = rmap_error_set(err, RMAP_INPUT, "it is no whole OpenEXR picture: %s",
                            exr_get_default_error_message(code));
    const size_t n = st == RMAP_OK && grey ? (size_t)picture->size[0] * picture->size[1] : 0;
    for (size_t i = 0; i < n; i++)
        picture->rgb[3 * i + 1] = picture->rgb[3 * i + 2] = picture->rgb[3 * i];
    (void)exr_finish(&file);
    return st;
}
