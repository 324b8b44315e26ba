/* SPDX-License-Identifier: MIT */
#ifndef RAYMAP_HAVE_ISAL

#include "io/deflate_planes.h"

#include <libdeflate.h>

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

size_t rmap_deflate_bound(size_t n_plane, size_t plane_nbytes)
{
    return libdeflate_zlib_compress_bound(NULL, n_plane * plane_nbytes);
}

struct rmap_stream_size rmap_deflate_planes(struct rmap_deflater *deflater, const uint8_t *plane,
                                            size_t n_plane, size_t plane_nbytes, uint8_t *out)
{
    size_t nbytes = libdeflate_zlib_compress(deflater->compressor, plane, n_plane * plane_nbytes,
                                             out, rmap_deflate_bound(n_plane, plane_nbytes));
    return (struct rmap_stream_size){nbytes, 0, (uint16_t)n_plane};
}

#else
typedef int rmap_deflate_planes_is_elsewhere; /* a file must hold something */
#endif
