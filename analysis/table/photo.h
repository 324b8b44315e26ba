/* SPDX-License-Identifier: MIT
 *
 * A rendered picture as files: linear values (EXR), or what a screen shows (PNG).
 */
#ifndef RMAP_PHOTO_H
#define RMAP_PHOTO_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

struct rmap_photo {
    uint32_t size[2];
    const float *rgb;    /* [size[1]][size[0]][3] linear, upper row first */
    double exposure;     /* display value of 1; display values above 1 are white */
    const char *comment; /* kept in an EXR */
};

/* The exposure that lets one in a hundred of the pixels that are not black go beyond white; 1 for a
 * dark picture. counts: [n_pixel] 1 for those that are looked at, others where there is no such.
 * RMAP_SYSTEM when memory is short. */
enum rmap_status rmap_photo_expose(const float *rgb, const uint8_t *counts, size_t n_pixel,
                                   double *exposure, struct rmap_error *err) RMAP_MUST_USE;

/* Writes the picture by the suffix of its name, .png or .exr, whole or not at all, in place of what
 * stands there. RMAP_USAGE for another suffix. */
enum rmap_status rmap_photo_write(const struct rmap_photo *photo, const char *path,
                                  struct rmap_error *err) RMAP_MUST_USE;

#endif
