/* SPDX-License-Identifier: MIT
 *
 * The bytes of one stored chunk: HDF5's filters shuffle, deflate and fletcher32, computed by our
 * own threads so that HDF5's lock never sees them. Any HDF5 tool reads the result.
 *
 * A chunk is n elements of 1, 2, 4 or 8 bytes, little-endian. Stored: one zlib stream of the
 * shuffled bytes, then fletcher32 of that stream, little-endian.
 */
#ifndef RMAP_CODEC_H
#define RMAP_CODEC_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "io/codec/zlib_stream.h"

/* Most stored bytes of n elements, fletcher32 among them. */
size_t rmap_codec_bound(size_t n, size_t element_nbytes);

/* Not thread-safe: one per thread. */
struct rmap_encoder;
enum rmap_status rmap_encoder_create(struct rmap_encoder **encoder_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;
void rmap_encoder_destroy(struct rmap_encoder *encoder);

/* Encodes n elements, of which raw has the first n_used, and the others are 0, into stored, which
 * has room for rmap_codec_bound bytes. The same input gives the same output, whatever was encoded
 * before. RMAP_SYSTEM when memory is short. */
enum rmap_status rmap_encoder_encode(struct rmap_encoder *encoder, const void *raw, size_t n_used,
                                     size_t n, size_t element_nbytes, uint8_t *stored,
                                     size_t *nbytes_ret, struct rmap_error *err) RMAP_MUST_USE;

/* Bits of `how`. RUNS: deflated by runs alone where that takes less of the first 4096 bytes. QUICK:
 * left as they are where deflate leaves more than 0.6 of the last 4096 bytes, or of all. */
enum { RMAP_ENCODE_RUNS = 1, RMAP_ENCODE_QUICK = 2 };

/* The same of elements that are shuffled already: plane [element_nbytes][n]. Stored bytes. */
size_t rmap_encoder_encode_planes(struct rmap_encoder *encoder, const uint8_t *plane, size_t n,
                                  size_t element_nbytes, unsigned how, uint8_t *stored);

struct rmap_decoder;
enum rmap_status rmap_decoder_create(struct rmap_decoder **decoder_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;
void rmap_decoder_destroy(struct rmap_decoder *decoder);

/* Decodes a chunk of exactly n elements as far as its byte planes, [element_nbytes][n]; any range
 * of elements then comes out of them by rmap_unshuffle. stored: [nbytes + RMAP_INFLATE_SLACK].
 * RMAP_FORMAT when the bytes are not that. */
enum rmap_status rmap_decoder_planes(struct rmap_decoder *decoder, const uint8_t *stored,
                                     size_t nbytes, size_t n, size_t element_nbytes, uint8_t *plane,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* HDF5's fletcher32 filter: Fletcher's sums of big-endian 16-bit words modulo 65535, where 0
 * stands for "all words 0" only. */
uint32_t rmap_fletcher32(const uint8_t *data, size_t nbytes);

/* XXH3-64 of the stored bytes: what fletcher32 misses (0000 for FFFF), this finds. */
uint64_t rmap_checksum(const void *data, size_t nbytes);

#endif
