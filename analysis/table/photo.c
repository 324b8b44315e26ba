/* SPDX-License-Identifier: MIT
 *
 * A rendered picture as files: linear values (EXR), or what a screen shows (PNG).
 */
#include "analysis/table/photo.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "analysis/table/colour_map.h"
#include "base/alloc.h"
#include "io/export/exr.h"
#include "io/export/raster.h"
#include "optics/spectrum.h"

static int ascending(const void *a, const void *b)
{
    const float *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

/* Luminances above 0, of pixels with that mark; how many. */
static size_t gather(const float *rgb, const uint8_t *counts, uint8_t wanted, size_t n_pixel,
                     float *lit)
{
    size_t n = 0;
    for (size_t i = 0; i < n_pixel; i++) {
        const double pixel[3] = {(double)rgb[3 * i], (double)rgb[3 * i + 1],
                                 (double)rgb[3 * i + 2]};
        const float luminance = (float)rmap_rgb_luminance(pixel);
        if (luminance > 0.0f && counts[i] == wanted)
            lit[n++] = luminance;
    }
    return n;
}

enum rmap_status rmap_photo_expose(const float *rgb, const uint8_t *counts, size_t n_pixel,
                                   double *exposure, struct rmap_error *err)
{
    float *lit = rmap_alloc(n_pixel, sizeof *lit);
    if (!lit)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the exposure");
    size_t n = gather(rgb, counts, 1, n_pixel, lit);
    if (n == 0)
        n = gather(rgb, counts, 0, n_pixel, lit);
    qsort(lit, n, sizeof *lit, ascending);
    *exposure = n > 0 ? 1.0 / (double)lit[n - 1 - n / 100] : 1.0;
    rmap_free(lit);
    return RMAP_OK;
}

static enum rmap_status write_png(const struct rmap_photo *photo, const char *path,
                                  struct rmap_error *err)
{
    size_t n = (size_t)photo->size[0] * photo->size[1];
    uint8_t *bytes = rmap_alloc(n, 3);
    if (!bytes)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a picture");
    for (size_t i = 0; i < n; i++) {
        double linear[3];
        for (size_t k = 0; k < 3; k++)
            linear[k] = photo->exposure * (double)photo->rgb[3 * i + k];
        rmap_srgb_encode(linear, bytes + 3 * i);
    }
    enum rmap_status st = rmap_png_write(bytes, photo->size[0], photo->size[1], path, err);
    rmap_free(bytes);
    return st;
}

static enum rmap_status write_exr(const struct rmap_photo *photo, const char *path,
                                  struct rmap_error *err)
{
    struct rmap_exr image = {
        .size = {photo->size[0], photo->size[1]}, .rgb = photo->rgb, .comment = photo->comment};
    return rmap_exr_write(&image, path, err);
}

enum rmap_status rmap_photo_write(const struct rmap_photo *photo, const char *path,
                                  struct rmap_error *err)
{
    const char *suffix = strrchr(path, '.');
    const bool png = suffix && strcasecmp(suffix, ".png") == 0;
    if (!png && !(suffix && strcasecmp(suffix, ".exr") == 0))
        return rmap_error_set(err, RMAP_USAGE, "'%s': a picture's name ends in .png or .exr", path);
    return png ? write_png(photo, path, err) : write_exr(photo, path, err);
}
