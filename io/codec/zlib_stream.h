/* SPDX-License-Identifier: MIT
 *
 * zlib streams (RFC 1950) of known length: by libdeflate, or by zlib where that is not there. Each
 * reads what the other wrote.
 */
#ifndef RMAP_ZLIB_STREAM_H
#define RMAP_ZLIB_STREAM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

/* "1.14"; "" where zlib does the work. */
const char *rmap_libdeflate_version(void);

/* Most bytes that the stream of nbytes bytes takes, whoever wrote it. */
size_t rmap_deflate_bound(size_t nbytes);

/* Not thread-safe: one per thread. runs: looks for runs of a byte alone (zlib's Z_RLE), which takes
 * less of bytes that repeat by chance: a match costs more there than what it stands for. */
struct rmap_deflater;
enum rmap_status rmap_deflater_create(bool runs, struct rmap_deflater **deflater_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;
void rmap_deflater_destroy(struct rmap_deflater *deflater); /* NULL is fine */

/* Writes the stream of `data` to `out`, which has room for rmap_deflate_bound. Its length. Equal
 * data give equal bytes, whatever was deflated before. */
size_t rmap_deflate(struct rmap_deflater *deflater, const void *data, size_t nbytes, uint8_t *out);

/* The same in blocks that are stored as they are: read nearly as fast as memory is copied. */
size_t rmap_deflate_none(const void *data, size_t nbytes, uint8_t *out);

/* Not thread-safe: one per thread. */
struct rmap_inflater;
enum rmap_status rmap_inflater_create(struct rmap_inflater **inflater_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;
void rmap_inflater_destroy(struct rmap_inflater *inflater); /* NULL is fine */

/* Behind a stream to inflate so many bytes can be read; what they are does not matter. libdeflate
 * decodes what stands in the last bytes of its input byte by byte, and that may be most of a chunk:
 * in a chunk of small numbers the high bytes, which are all 0. */
#define RMAP_INFLATE_SLACK 64

/* False unless the first n_in bytes of `in` are one whole stream, and give exactly n_out bytes. */
bool rmap_inflate(struct rmap_inflater *inflater, const uint8_t *in, size_t n_in, uint8_t *out,
                  size_t n_out);

#endif
