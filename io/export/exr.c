/* SPDX-License-Identifier: MIT
 *
 * OpenEXR pictures (ISO/ASC TR: openexr.com, file layout 2.0), through OpenEXRCore.
 */
#include "io/export/exr.h"

#include <errno.h>
#include <openexr.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "io/file/whole_file.h"

struct writer {
    const struct rmap_exr *image;
    exr_context_t file;
    int part;
    exr_encode_pipeline_t encoder;
    FILE *out;
    int error; /* of the system, for the first write that failed */
};

/* The library's own writing holds a lock while it reports an error, which a reporter that asks for
 * its user data waits for. */
static int64_t write_bytes(exr_const_context_t file, void *user, const void *bytes, uint64_t nbytes,
                           uint64_t at, exr_stream_error_func_ptr_t report)
{
    struct writer *writer = user;
    (void)file;
    (void)report;
    errno = 0;
    if (fseeko(writer->out, (off_t)at, SEEK_SET) == 0 &&
        fwrite(bytes, 1, (size_t)nbytes, writer->out) == nbytes)
        return (int64_t)nbytes;
    if (writer->error == 0)
        writer->error = errno ? errno : EIO;
    return -1;
}

/* Codes say enough; without a reporter the library prints. */
static void report_nothing(exr_const_context_t file, exr_result_t code, const char *message)
{
    (void)file;
    (void)code;
    (void)message;
}

#define EXR_TRY(call)                                                                              \
    do {                                                                                           \
        exr_result_t exr_code = (call);                                                            \
        if (exr_code != EXR_ERR_SUCCESS)                                                           \
            return exr_code;                                                                       \
    } while (0)

static exr_result_t write_head(struct writer *writer)
{
    static const char *const channel[] = {"B", "G", "R"};
    const struct rmap_exr *image = writer->image;
    EXR_TRY(exr_add_part(writer->file, "picture", EXR_STORAGE_SCANLINE, &writer->part));
    EXR_TRY(exr_initialize_required_attr_simple(writer->file, writer->part, (int)image->size[0],
                                                (int)image->size[1], EXR_COMPRESSION_ZIP));
    for (int k = 0; k < 3; k++)
        EXR_TRY(exr_add_channel(writer->file, writer->part, channel[k], EXR_PIXEL_FLOAT,
                                EXR_PERCEPTUALLY_LINEAR, 1, 1));
    EXR_TRY(exr_attr_set_string(writer->file, writer->part, "comments", image->comment));
    return exr_write_header(writer->file);
}

/* The rows of one chunk, from y on, interleaved as they are. */
static exr_result_t write_chunk(struct writer *writer, const exr_chunk_info_t *chunk, int y)
{
    const struct rmap_exr *image = writer->image;
    exr_encode_pipeline_t *encoder = &writer->encoder;
    bool first = y == 0;
    if (first)
        EXR_TRY(exr_encoding_initialize(writer->file, writer->part, chunk, encoder));
    else
        EXR_TRY(exr_encoding_update(writer->file, writer->part, chunk, encoder));
    for (int16_t c = 0; c < encoder->channel_count; c++) {
        exr_coding_channel_info_t *channel = &encoder->channels[c];
        size_t k = channel->channel_name[0] == 'R' ? 0 : channel->channel_name[0] == 'G' ? 1 : 2;
        const float *start = image->rgb + 3 * (size_t)y * image->size[0] + k;
        channel->user_bytes_per_element = sizeof(float);
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_pixel_stride = 3 * (int32_t)sizeof(float);
        channel->user_line_stride = 3 * (int32_t)sizeof(float) * (int32_t)image->size[0];
        channel->encode_from_ptr = (const uint8_t *)start;
    }
    if (first)
        EXR_TRY(exr_encoding_choose_default_routines(writer->file, writer->part, encoder));
    return exr_encoding_run(writer->file, writer->part, encoder);
}

static exr_result_t write_rows(struct writer *writer)
{
    int32_t step = 0;
    EXR_TRY(exr_get_scanlines_per_chunk(writer->file, writer->part, &step));
    for (int y = 0; y < (int)writer->image->size[1]; y += step) {
        exr_chunk_info_t chunk;
        EXR_TRY(exr_write_scanline_chunk_info(writer->file, writer->part, y, &chunk));
        EXR_TRY(write_chunk(writer, &chunk, y));
    }
    return EXR_ERR_SUCCESS;
}

/* The whole picture into a new file. */
static exr_result_t write_file(struct writer *writer, const char *path)
{
    exr_context_initializer_t options = EXR_DEFAULT_CONTEXT_INITIALIZER;
    options.error_handler_fn = report_nothing;
    options.write_fn = write_bytes;
    options.user_data = writer;
    exr_result_t code = exr_start_write(&writer->file, path, EXR_WRITE_FILE_DIRECTLY, &options);
    if (code != EXR_ERR_SUCCESS)
        return code;
    code = write_head(writer);
    if (code == EXR_ERR_SUCCESS)
        code = write_rows(writer);
    (void)exr_encoding_destroy(writer->file, &writer->encoder);
    exr_result_t closed = exr_finish(&writer->file);
    return code == EXR_ERR_SUCCESS ? closed : code;
}

enum rmap_status rmap_exr_write(const struct rmap_exr *image, const char *path,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_whole_file whole = {0};
    struct writer writer = {.image = image, .encoder = EXR_ENCODE_PIPELINE_INITIALIZER};
    RMAP_TRY(rmap_whole_file_open(&whole, path, err));
    writer.out = whole.file;
    exr_result_t code = write_file(&writer, whole.temporary);
    if (code == EXR_ERR_SUCCESS)
        st = rmap_whole_file_finish(&whole, err);
    else
        st = rmap_error_set(err, RMAP_SYSTEM, "cannot write '%s': %s", path,
                            writer.error ? strerror(writer.error)
                                         : exr_get_default_error_message(code));
out:
    rmap_whole_file_fini(&whole);
    return st;
}
