/* SPDX-License-Identifier: MIT
 *
 * zlib streams (RFC 1950) of known length: by libdeflate, or by zlib where that is not there; by
 * runs always by zlib.
 */
#include "io/codec/zlib_stream.h"

#define ZLIB_CONST
#include <limits.h>
#ifdef RAYMAP_HAVE_LIBDEFLATE
#include <libdeflate.h>
#endif
#include <string.h>
#include <zlib.h>

#include "base/alloc.h"

/* What a level more saves of a map is a few per cent, and takes as long again. */
#define LEVEL 1

size_t rmap_deflate_bound(size_t nbytes)
{
    return nbytes + nbytes / 256 + 1024; /* stored blocks, of any length, in up to eight parts */
}

struct rmap_deflater {
#ifdef RAYMAP_HAVE_LIBDEFLATE
    struct libdeflate_compressor *compressor; /* NULL: the stream does it */
#endif
    z_stream stream;
};

static void *zlib_alloc(void *opaque, unsigned n, unsigned size)
{
    (void)opaque;
    return rmap_alloc(n, size);
}

static void zlib_free(void *opaque, void *block)
{
    (void)opaque;
    rmap_free(block);
}

/* Lengths of zlib are 32 bits; chunks are far shorter. */
static bool fits(size_t n_in, size_t n_out)
{
    return n_in <= UINT_MAX && n_out <= UINT_MAX;
}

static bool begin_deflate(struct rmap_deflater *self, bool runs)
{
#ifdef RAYMAP_HAVE_LIBDEFLATE
    if (!runs) {
        self->compressor = libdeflate_alloc_compressor(LEVEL);
        return self->compressor != NULL;
    }
#endif
    self->stream = (z_stream){.zalloc = zlib_alloc, .zfree = zlib_free};
    return deflateInit2(&self->stream, LEVEL, Z_DEFLATED, MAX_WBITS, MAX_MEM_LEVEL,
                        runs ? Z_RLE : Z_DEFAULT_STRATEGY) == Z_OK;
}

static void end_deflate(struct rmap_deflater *self)
{
#ifdef RAYMAP_HAVE_LIBDEFLATE
    libdeflate_free_compressor(self->compressor);
#endif
    (void)deflateEnd(&self->stream); /* one that was never begun is refused */
}

size_t rmap_deflate(struct rmap_deflater *deflater, const void *data, size_t nbytes, uint8_t *out)
{
    z_stream *stream = &deflater->stream;
    const size_t bound = rmap_deflate_bound(nbytes);
#ifdef RAYMAP_HAVE_LIBDEFLATE
    if (deflater->compressor)
        return libdeflate_zlib_compress(deflater->compressor, data, nbytes, out, bound);
#endif
    if (!fits(nbytes, bound) || deflateReset(stream) != Z_OK)
        return 0;
    stream->next_in = data;
    stream->avail_in = (uInt)nbytes;
    stream->next_out = out;
    stream->avail_out = (uInt)bound;
    return deflate(stream, Z_FINISH) == Z_STREAM_END ? bound - stream->avail_out : 0;
}

#ifdef RAYMAP_HAVE_LIBDEFLATE
const char *rmap_libdeflate_version(void)
{
    return LIBDEFLATE_VERSION_STRING;
}

struct rmap_inflater {
    struct libdeflate_decompressor *decompressor;
};

static bool begin_inflate(struct rmap_inflater *self)
{
    self->decompressor = libdeflate_alloc_decompressor();
    return self->decompressor != NULL;
}

static void end_inflate(struct rmap_inflater *self)
{
    libdeflate_free_decompressor(self->decompressor);
}

static uint32_t sum_bytes(const void *data, size_t nbytes)
{
    return libdeflate_adler32(1, data, nbytes);
}

bool rmap_inflate(struct rmap_inflater *inflater, const uint8_t *in, size_t n_in, uint8_t *out,
                  size_t n_out)
{
    size_t n = 0;
    return libdeflate_zlib_decompress_ex(inflater->decompressor, in, n_in + RMAP_INFLATE_SLACK, out,
                                         n_out, &n, NULL) == LIBDEFLATE_SUCCESS &&
           n == n_in;
}
#else
const char *rmap_libdeflate_version(void)
{
    return "";
}

struct rmap_inflater {
    z_stream stream;
};

static bool begin_inflate(struct rmap_inflater *self)
{
    self->stream = (z_stream){.zalloc = zlib_alloc, .zfree = zlib_free};
    return inflateInit(&self->stream) == Z_OK;
}

static void end_inflate(struct rmap_inflater *self)
{
    (void)inflateEnd(&self->stream);
}

static uint32_t sum_bytes(const void *data, size_t nbytes)
{
    return (uint32_t)adler32_z(1, data, nbytes);
}

bool rmap_inflate(struct rmap_inflater *inflater, const uint8_t *in, size_t n_in, uint8_t *out,
                  size_t n_out)
{
    z_stream *stream = &inflater->stream;
    if (!fits(n_in, n_out) || inflateReset(stream) != Z_OK)
        return false;
    stream->next_in = in;
    stream->avail_in = (uInt)n_in;
    stream->next_out = out;
    stream->avail_out = (uInt)n_out;
    return inflate(stream, Z_FINISH) == Z_STREAM_END && stream->avail_in == 0 &&
           stream->avail_out == 0;
}
#endif

size_t rmap_deflate_none(const void *data, size_t nbytes, uint8_t *out)
{
    enum { MOST = 65535 };
    static const uint8_t head[] = {0x78, 0x01}; /* RFC 1950 */
    const uint8_t *from = data;
    const uint32_t sum = sum_bytes(data, nbytes);
    uint8_t *to = out;
    size_t left = nbytes;
    memcpy(to, head, sizeof head);
    to += sizeof head;
    do { /* RFC 1951, 3.2.4 */
        const size_t n = left < MOST ? left : MOST;
        *to++ = n == left;
        *to++ = (uint8_t)n;
        *to++ = (uint8_t)(n >> 8);
        *to++ = (uint8_t)~n;
        *to++ = (uint8_t)(~n >> 8);
        if (n > 0)
            memcpy(to, from, n);
        to += n;
        from += n;
        left -= n;
    } while (left > 0);
    for (int shift = 24; shift >= 0; shift -= 8)
        *to++ = (uint8_t)(sum >> shift);
    return (size_t)(to - out);
}

enum rmap_status rmap_deflater_create(bool runs, struct rmap_deflater **deflater_ret,
                                      struct rmap_error *err)
{
    struct rmap_deflater *self = rmap_alloc(1, sizeof *self);
    if (!self || !begin_deflate(self, runs)) {
        rmap_free(self);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a compressor");
    }
    *deflater_ret = self;
    return RMAP_OK;
}

void rmap_deflater_destroy(struct rmap_deflater *deflater)
{
    if (deflater)
        end_deflate(deflater);
    rmap_free(deflater);
}

enum rmap_status rmap_inflater_create(struct rmap_inflater **inflater_ret, struct rmap_error *err)
{
    struct rmap_inflater *self = rmap_alloc(1, sizeof *self);
    if (!self || !begin_inflate(self)) {
        rmap_free(self);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a decoder");
    }
    *inflater_ret = self;
    return RMAP_OK;
}

void rmap_inflater_destroy(struct rmap_inflater *inflater)
{
    if (inflater)
        end_inflate(inflater);
    rmap_free(inflater);
}
