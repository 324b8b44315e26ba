/* SPDX-License-Identifier: MIT */
#ifndef RAYMAP_HAVE_ISAL

#include "io/codec/deflate_planes.h"

#include <libdeflate.h>
#include <stdbool.h>
#include <string.h>

#include "base/alloc.h"

#define LEVEL 1

struct rmap_deflater {
    struct libdeflate_compressor *compressor;
};

enum rmap_status rmap_deflater_create(struct rmap_deflater **deflater_ret, struct rmap_error *err)
{
    struct rmap_deflater *deflater = rmap_alloc(1, sizeof *deflater);
    if (deflater)
        deflater->compressor = libdeflate_alloc_compressor(LEVEL);
    if (!deflater || !deflater->compressor) {
        rmap_free(deflater);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a compressor");
    }
    *deflater_ret = deflater;
    return RMAP_OK;
}

void rmap_deflater_destroy(struct rmap_deflater *deflater)
{
    if (deflater)
        libdeflate_free_compressor(deflater->compressor);
    rmap_free(deflater);
}

static size_t stream_bound(size_t nbytes)
{
    return libdeflate_zlib_compress_bound(NULL, nbytes);
}

size_t rmap_deflate_bound(size_t n_plane, size_t plane_nbytes)
{
    return stream_bound(n_plane * plane_nbytes) + n_plane * plane_nbytes;
}

static void put_whole(const uint8_t *plane, size_t stride, size_t n_plane, size_t n_used,
                      size_t n_zero, uint8_t *whole)
{
    for (size_t k = 0; k < n_plane; k++) {
        memcpy(whole + k * (n_used + n_zero), plane + k * stride, n_used);
        memset(whole + k * (n_used + n_zero) + n_used, 0, n_zero);
    }
}

/* The planes stand behind the stream's end until they are compressed. */
struct rmap_stream_size rmap_deflate_planes(struct rmap_deflater *deflater,
                                            struct rmap_plane_habit *habit, const uint8_t *plane,
                                            size_t stride, size_t n_plane, size_t n_used,
                                            size_t n_zero, uint8_t *out)
{
    (void)habit; /* one method for all */
    size_t all = n_plane * (n_used + n_zero), bound = stream_bound(all);
    uint8_t *whole = out + bound;
    bool copied = n_zero > 0 || stride != n_used;
    if (copied)
        put_whole(plane, stride, n_plane, n_used, n_zero, whole);
    size_t nbytes =
        libdeflate_zlib_compress(deflater->compressor, copied ? whole : plane, all, out, bound);
    return (struct rmap_stream_size){nbytes, 0, (uint16_t)n_plane};
}

#else
typedef int rmap_deflate_planes_is_elsewhere; /* a file must hold something */
#endif
