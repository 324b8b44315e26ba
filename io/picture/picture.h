/* SPDX-License-Identifier: MIT
 *
 * Pictures of high dynamic range: the bytes of a file to numbers.
 */
#ifndef RMAP_PICTURE_H
#define RMAP_PICTURE_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

#define RMAP_PICTURE_PIXELS_MAX ((uint64_t)1 << 24)

struct rmap_picture {
    uint32_t size[2];
    float *rgb; /* [size[1]][size[0]][3]: upper row first, from left to right; finite, >= 0 */
};

/* By what the file begins with: Radiance's RGBE (.hdr, .pic; any order of rows and columns, both
 * run-length encodings and none; EXPOSURE and COLORCORR are divided out) or OpenEXR (.exr; scan
 * lines of R, G and B, or of Y; below 0 is taken as 0). RMAP_INPUT: neither, damaged, too large.
 * *picture is the caller's to finish. */
enum rmap_status rmap_picture_read(const uint8_t *bytes, size_t nbytes,
                                   struct rmap_picture *picture,
                                   struct rmap_error *err) RMAP_MUST_USE;
void rmap_picture_fini(struct rmap_picture *picture);

/* The two, and room for a picture of any size that is allowed. */
enum rmap_status rmap_picture_rgbe(const uint8_t *bytes, size_t nbytes,
                                   struct rmap_picture *picture,
                                   struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_picture_exr(const uint8_t *bytes, size_t nbytes, struct rmap_picture *picture,
                                  struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_picture_init(struct rmap_picture *picture, uint64_t width, uint64_t height,
                                   struct rmap_error *err) RMAP_MUST_USE;

#endif
