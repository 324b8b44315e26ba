/* SPDX-License-Identifier: MIT
 *
 * OpenEXR pictures (ISO/ASC TR: openexr.com, file layout 2.0), through OpenEXRCore. This module
 * alone knows it.
 */
#ifndef RMAP_EXR_H
#define RMAP_EXR_H

#include <stdint.h>

#include "base/status.h"

/* Linear RGB with the primaries and the white of IEC 61966-2-1 (EXR's own defaults). */
struct rmap_exr {
    uint32_t size[2];
    const float *rgb;    /* [size[1]][size[0]][3], upper row first */
    const char *comment; /* kept in the file */
};

/* A scan-line file of 32-bit floats R, G, B, zip-compressed; replaces what is there. RMAP_SYSTEM,
 * with nothing left behind. */
enum rmap_status rmap_exr_write(const struct rmap_exr *image, const char *path,
                                struct rmap_error *err) RMAP_MUST_USE;

#endif
