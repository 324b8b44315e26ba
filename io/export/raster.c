/* SPDX-License-Identifier: MIT
 *
 * Pixels: PNG images in memory, and pictures written to files as SVG or rasterised to PNG.
 */
#include "io/export/raster.h"

#include <png.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include <librsvg/rsvg.h>

#include "base/alloc.h"
#include "base/count.h"
#include "base/late_library.h"
#include "io/file/whole_file.h"

struct bytes {
    uint8_t *data;
    size_t n, cap;
};

static enum rmap_status append(struct bytes *bytes, const uint8_t *data, size_t n)
{
    enum rmap_status st = RMAP_RESERVE(bytes->data, bytes->cap, bytes->n + n, NULL);
    if (st != RMAP_OK)
        return st;
    memcpy(bytes->data + bytes->n, data, n);
    bytes->n += n;
    return RMAP_OK;
}

enum rmap_status rmap_png_encode(const uint8_t *rgb, uint32_t width, uint32_t height,
                                 uint8_t **png_ret, size_t *nbytes_ret, struct rmap_error *err)
{
    png_image image = {
        .version = PNG_IMAGE_VERSION, .width = width, .height = height, .format = PNG_FORMAT_RGB};
    png_alloc_size_t nbytes = PNG_IMAGE_PNG_SIZE_MAX(image);
    uint8_t *png = rmap_alloc(nbytes, 1);
    if (!png)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for an image of %u x %u", width,
                              height);
    if (!png_image_write_to_memory(&image, png, &nbytes, 0, rgb, 0, NULL)) {
        rmap_free(png);
        return rmap_error_set(err, RMAP_SYSTEM, "cannot encode an image of %u x %u: %s", width,
                              height, image.message);
    }
    *png_ret = png;
    *nbytes_ret = nbytes;
    return RMAP_OK;
}

enum rmap_picture rmap_picture_kind(const char *path)
{
    const char *suffix = strrchr(path, '.');
    if (suffix && strcasecmp(suffix, ".svg") == 0)
        return RMAP_PICTURE_SVG;
    if (suffix && strcasecmp(suffix, ".png") == 0)
        return RMAP_PICTURE_PNG;
    return RMAP_PICTURE_NONE;
}

enum rmap_status rmap_png_write(const uint8_t *rgb, uint32_t width, uint32_t height,
                                const char *path, struct rmap_error *err)
{
    uint8_t *png = NULL;
    size_t nbytes = 0;
    enum rmap_status st = rmap_png_encode(rgb, width, height, &png, &nbytes, err);
    if (st == RMAP_OK)
        st = rmap_whole_file_put_bytes(path, png, nbytes, err);
    rmap_free(png);
    return st;
}

#define DRAWING(X)                                                                                 \
    X(cairo_image_surface_create)                                                                  \
    X(cairo_create)                                                                                \
    X(cairo_set_source_rgb)                                                                        \
    X(cairo_paint)                                                                                 \
    X(cairo_surface_flush)                                                                         \
    X(cairo_surface_write_to_png_stream)                                                           \
    X(cairo_status_to_string)                                                                      \
    X(cairo_destroy)                                                                               \
    X(cairo_surface_destroy)                                                                       \
    X(rsvg_handle_new_from_data)                                                                   \
    X(rsvg_handle_render_document)                                                                 \
    X(g_clear_error)                                                                               \
    X(g_object_unref)

struct drawing {
    DRAWING(RMAP_LATE_MEMBER)
};
static const char *const drawing_name[] = {DRAWING(RMAP_LATE_NAME)};

static cairo_status_t keep_png(void *closure, const unsigned char *data, unsigned int length)
{
    return append(closure, data, length) == RMAP_OK ? CAIRO_STATUS_SUCCESS
                                                    : CAIRO_STATUS_WRITE_ERROR;
}

static enum rmap_status rasterise(const char *text, size_t nbytes, int width, int height,
                                  struct bytes *png, struct rmap_error *err)
{
    struct drawing by;
    enum rmap_status st =
        rmap_late_library(RMAP_LIBRSVG, "PNG pictures, not .svg, are drawn by librsvg",
                          drawing_name, RMAP_COUNT(drawing_name), &by, err);
    if (st != RMAP_OK)
        return st;
    GError *failure = NULL;
    cairo_surface_t *surface = by.cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height);
    cairo_t *cairo = by.cairo_create(surface);
    RsvgHandle *handle = by.rsvg_handle_new_from_data((const guint8 *)text, nbytes, &failure);
    RsvgRectangle viewport = {0, 0, width, height};
    by.cairo_set_source_rgb(cairo, 1.0, 1.0,
                            1.0); /* what a size of half pixels leaves at the edges */
    by.cairo_paint(cairo);
    if (handle && by.rsvg_handle_render_document(handle, cairo, &viewport, &failure)) {
        by.cairo_surface_flush(surface);
        cairo_status_t drawn = by.cairo_surface_write_to_png_stream(surface, keep_png, png);
        st = drawn == CAIRO_STATUS_SUCCESS
                 ? RMAP_OK
                 : rmap_error_set(err, RMAP_SYSTEM, "cannot draw a picture of %d x %d: %s", width,
                                  height, by.cairo_status_to_string(drawn));
    } else {
        st = rmap_error_set(err, RMAP_SYSTEM, "librsvg cannot draw the picture: %s",
                            failure ? failure->message : "no reason given");
    }
    by.g_clear_error(&failure);
    if (handle)
        by.g_object_unref(handle);
    by.cairo_destroy(cairo);
    by.cairo_surface_destroy(surface);
    return st;
}

enum rmap_status rmap_picture_png(struct rmap_svg *svg, double scale, uint8_t **png_ret,
                                  size_t *nbytes_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct bytes png = {0};
    const char *text = NULL;
    size_t nbytes = 0;
    RMAP_TRY(rmap_svg_finish(svg, &text, &nbytes, err));
    RMAP_TRY(rasterise(text, nbytes, (int)(rmap_svg_width(svg) * scale + 0.5),
                       (int)(rmap_svg_height(svg) * scale + 0.5), &png, err));
    *png_ret = png.data;
    *nbytes_ret = png.n;
    png.data = NULL;
out:
    rmap_free(png.data);
    return st;
}

enum rmap_status rmap_picture_write(struct rmap_svg *svg, const char *path, double scale,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint8_t *png = NULL;
    const char *text = NULL;
    size_t nbytes = 0;
    enum rmap_picture kind = rmap_picture_kind(path);
    if (kind == RMAP_PICTURE_NONE)
        return rmap_error_set(err, RMAP_USAGE, "'%s': a picture's name ends in .svg or .png", path);
    if (kind == RMAP_PICTURE_SVG) {
        RMAP_TRY(rmap_svg_finish(svg, &text, &nbytes, err));
        st = rmap_whole_file_put_bytes(path, text, nbytes, err);
        goto out;
    }
    RMAP_TRY(rmap_picture_png(svg, scale, &png, &nbytes, err));
    st = rmap_whole_file_put_bytes(path, png, nbytes, err);
out:
    rmap_free(png);
    return st;
}
