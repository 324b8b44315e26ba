/* SPDX-License-Identifier: MIT
 *
 * Pictures of high dynamic range: the bytes of a file to numbers.
 */
#include "io/picture/picture.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"

enum rmap_status rmap_picture_init(struct rmap_picture *picture, uint64_t width, uint64_t height,
                                   struct rmap_error *err)
{
    if (width < 1 || height < 1 || width > RMAP_PICTURE_PIXELS_MAX ||
        height > RMAP_PICTURE_PIXELS_MAX || width * height > RMAP_PICTURE_PIXELS_MAX)
        return rmap_error_set(err, RMAP_INPUT,
                              "a picture has 1 to %llu pixels: make it smaller, as 4096 x 2048",
                              (unsigned long long)RMAP_PICTURE_PIXELS_MAX);
    picture->size[0] = (uint32_t)width;
    picture->size[1] = (uint32_t)height;
    picture->rgb = rmap_alloc(3 * (size_t)(width * height), sizeof *picture->rgb);
    return picture->rgb ? RMAP_OK : rmap_error_set(err, RMAP_SYSTEM, "out of memory for a picture");
}

void rmap_picture_fini(struct rmap_picture *picture)
{
    rmap_free(picture->rgb);
    picture->rgb = NULL;
}

enum rmap_status rmap_picture_read(const uint8_t *bytes, size_t nbytes,
                                   struct rmap_picture *picture, struct rmap_error *err)
{
    static const uint8_t exr[4] = {0x76, 0x2f, 0x31, 0x01};
    enum rmap_status st = RMAP_OK;
    *picture = (struct rmap_picture){.rgb = NULL};
    if (nbytes > 4 && memcmp(bytes, exr, 4) == 0)
        st = rmap_picture_exr(bytes, nbytes, picture, err);
    else if (nbytes > 2 && memcmp(bytes, "#?", 2) == 0)
        st = rmap_picture_rgbe(bytes, nbytes, picture, err);
    else
        return rmap_error_set(err, RMAP_INPUT,
                              "it is no picture of high dynamic range: Radiance's .hdr begins with "
                              "#?RADIANCE, OpenEXR's .exr with four bytes of its own");
    const size_t n = st == RMAP_OK ? 3 * (size_t)picture->size[0] * picture->size[1] : 0;
    for (size_t i = 0; i < n; i++) {
        if (!isfinite(picture->rgb[i]))
            return rmap_error_set(err, RMAP_INPUT, "pixel %zu has a value that is not finite",
                                  i / 3);
        picture->rgb[i] = picture->rgb[i] > 0.0F ? picture->rgb[i] : 0.0F;
    }
    return st;
}
