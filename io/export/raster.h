/* SPDX-License-Identifier: MIT
 *
 * Pixels: PNG images in memory, and pictures written to files as SVG or rasterised to PNG.
 */
#ifndef RMAP_RASTER_H
#define RMAP_RASTER_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "io/export/svg.h"

/* rgb: [height][width][3], first row on top. *png_ret: rmap_free. */
enum rmap_status rmap_png_encode(const uint8_t *rgb, uint32_t width, uint32_t height,
                                 uint8_t **png_ret, size_t *nbytes_ret,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* The same into a file, which stays away when it cannot be written whole. */
enum rmap_status rmap_png_write(const uint8_t *rgb, uint32_t width, uint32_t height,
                                const char *path, struct rmap_error *err) RMAP_MUST_USE;

enum rmap_picture { RMAP_PICTURE_NONE, RMAP_PICTURE_SVG, RMAP_PICTURE_PNG };

/* Kind of picture that a file name's suffix asks for. */
enum rmap_picture rmap_picture_kind(const char *path);

/* Finishes the picture as PNG at `scale` pixels per SVG pixel. *png_ret: rmap_free. */
enum rmap_status rmap_picture_png(struct rmap_svg *svg, double scale, uint8_t **png_ret,
                                  size_t *nbytes_ret, struct rmap_error *err) RMAP_MUST_USE;

/* Finishes the picture and writes it to `path`, in place of what stood there; PNG at `scale`
 * pixels per SVG pixel. RMAP_USAGE for another suffix, RMAP_SYSTEM when it cannot be written. */
enum rmap_status rmap_picture_write(struct rmap_svg *svg, const char *path, double scale,
                                    struct rmap_error *err) RMAP_MUST_USE;

#endif
