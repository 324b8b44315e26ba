/* SPDX-License-Identifier: MIT */
#include "io/codec/codec.h"

#include <string.h>

#include "base/alloc.h"
#include "base/wide.h"
#include "io/codec/inflate.h"
#include "io/codec/shuffle.h"
#include "io/codec/uniform_plane.h"
#include "portion/portion_hash.h"

#define FLETCHER_NBYTES 4

struct rmap_encoder {
    struct rmap_deflater *deflater;
    uint8_t *plane;
    size_t plane_cap;
};

struct rmap_decoder {
    struct rmap_inflater *inflater;
};

uint64_t rmap_checksum(const void *data, size_t nbytes)
{
    return rmap_hash64_fastest()(data, nbytes);
}

/* x modulo 65535 in 1..65535, but 0 for 0: the form that repeated folding leaves. */
static uint32_t fold(uint64_t x)
{
    return x ? (uint32_t)((x - 1) % 65535) + 1 : 0;
}

/* Fletcher's sums of n_group groups of 8 little-endian words, in 8 lanes that the compiler can
 * keep in vector registers. With a_j = sum of lane j and b_j = its sum of running sums, the
 * block's second sum is sum_j (8 b_j - j a_j). 256 groups keep b_j below 2^32. */
enum { LANES = 8, GROUPS_MAX = 256 };

RMAP_WIDE
static void fletcher_block(const uint8_t *data, size_t n_group, uint64_t *sum1, uint64_t *sum2)
{
    uint32_t a[LANES] = {0}, b[LANES] = {0};
    for (size_t g = 0; g < n_group; g++, data += 2 * LANES) {
        uint16_t word[LANES];
        memcpy(word, data, sizeof word);
        for (int j = 0; j < LANES; j++) {
            a[j] += word[j];
            b[j] += a[j];
        }
    }
    *sum2 += *sum1 * LANES * n_group;
    for (unsigned j = 0; j < LANES; j++) {
        *sum1 += a[j];
        *sum2 += (uint64_t)LANES * b[j] - (uint64_t)j * a[j];
    }
}

uint32_t rmap_fletcher32(const uint8_t *data, size_t nbytes)
{
    uint64_t sum1 = 0, sum2 = 0;
    size_t n_group = nbytes / (2 * LANES);
    const uint8_t *end = data + nbytes;
    while (n_group > 0) {
        size_t n = n_group < GROUPS_MAX ? n_group : GROUPS_MAX;
        fletcher_block(data, n, &sum1, &sum2);
        sum1 = fold(sum1);
        sum2 = fold(sum2);
        data += n * 2 * LANES;
        n_group -= n;
    }
    for (; data < end; data += 2) {
        sum1 += data[0] | (data + 1 < end ? (uint32_t)data[1] << 8 : 0);
        sum2 += sum1;
    }
    /* Words were read little-endian: swapping a word's bytes is multiplying by 256 mod 65535. */
    return fold(256 * (uint64_t)fold(sum2)) << 16 | fold(256 * (uint64_t)fold(sum1));
}

size_t rmap_codec_bound(size_t n, size_t element_nbytes)
{
    return rmap_deflate_bound(element_nbytes, n) + FLETCHER_NBYTES;
}

enum rmap_status rmap_encoder_create(struct rmap_encoder **encoder_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_encoder *encoder = rmap_alloc(1, sizeof *encoder);
    if (!encoder)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for an encoder");
    RMAP_TRY(rmap_deflater_create(&encoder->deflater, err));
    *encoder_ret = encoder;
    encoder = NULL;
out:
    rmap_encoder_destroy(encoder);
    return st;
}

void rmap_encoder_destroy(struct rmap_encoder *encoder)
{
    if (!encoder)
        return;
    rmap_deflater_destroy(encoder->deflater);
    rmap_free(encoder->plane);
    rmap_free(encoder);
}

static enum rmap_status planes_reserve(uint8_t **plane, size_t *cap, size_t nbytes,
                                       struct rmap_error *err)
{
    void *block = *plane;
    enum rmap_status st = rmap_reserve(&block, cap, nbytes, 1, err);
    *plane = block;
    return st;
}

struct rmap_stream_size rmap_encoder_encode_planes(struct rmap_encoder *encoder,
                                                   struct rmap_plane_habit *habit,
                                                   const uint8_t *plane, size_t stride,
                                                   size_t n_used, size_t n, size_t element_nbytes,
                                                   uint8_t *stored)
{
    struct rmap_stream_size size = rmap_deflate_planes(encoder->deflater, habit, plane, stride,
                                                       element_nbytes, n_used, n - n_used, stored);
    uint32_t sum = rmap_fletcher32(stored, size.nbytes);
    memcpy(stored + size.nbytes, &sum, FLETCHER_NBYTES);
    size.nbytes += FLETCHER_NBYTES;
    return size;
}

enum rmap_status rmap_encoder_encode_first(struct rmap_encoder *encoder, const void *raw,
                                           size_t n_used, size_t n, size_t element_nbytes,
                                           uint8_t *stored, struct rmap_stream_size *size_ret,
                                           struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(
        planes_reserve(&encoder->plane, &encoder->plane_cap, n_used * element_nbytes + 1, err));
    rmap_shuffle(raw, n_used, element_nbytes, encoder->plane, n_used);
    *size_ret = rmap_encoder_encode_planes(encoder, NULL, encoder->plane, n_used, n_used, n,
                                           element_nbytes, stored);
out:
    return st;
}

enum rmap_status rmap_encoder_encode(struct rmap_encoder *encoder, const void *raw, size_t n,
                                     size_t element_nbytes, uint8_t *stored,
                                     struct rmap_stream_size *size_ret, struct rmap_error *err)
{
    return rmap_encoder_encode_first(encoder, raw, n, n, element_nbytes, stored, size_ret, err);
}

enum rmap_status rmap_decoder_create(struct rmap_decoder **decoder_ret, struct rmap_error *err)
{
    struct rmap_decoder *decoder = rmap_alloc(1, sizeof *decoder);
    if (!decoder)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a decoder");
    enum rmap_status st = rmap_inflater_create(&decoder->inflater, err);
    if (st == RMAP_OK)
        *decoder_ret = decoder;
    else
        rmap_decoder_destroy(decoder);
    return st;
}

void rmap_decoder_destroy(struct rmap_decoder *decoder)
{
    if (!decoder)
        return;
    rmap_inflater_destroy(decoder->inflater);
    rmap_free(decoder);
}

/* A zlib header (RFC 1950 2.2) of a deflate stream without a preset dictionary. */
static bool is_zlib_header(const uint8_t *stream)
{
    return (stream[0] & 15) == 8 && (stream[0] * 256 + stream[1]) % 31 == 0 && !(stream[1] & 32);
}

enum { HEADER = 2, ADLER = 4 };

static enum rmap_status check_stored(const uint8_t *stored, const struct rmap_stream_size *size,
                                     size_t element_nbytes, struct rmap_error *err)
{
    uint32_t sum;
    if (size->nbytes < HEADER + ADLER + FLETCHER_NBYTES || !is_zlib_header(stored))
        return rmap_error_set(err, RMAP_FORMAT, "%zu bytes are no chunk", size->nbytes);
    size_t stream = size->nbytes - FLETCHER_NBYTES;
    memcpy(&sum, stored + stream, sizeof sum);
    if (sum != rmap_fletcher32(stored, stream))
        return rmap_error_set(err, RMAP_FORMAT, "fletcher32 does not match: the data are damaged");
    if (size->lead_planes < element_nbytes &&
        (size->lead_nbytes < HEADER || size->lead_nbytes > stream - ADLER))
        return rmap_error_set(err, RMAP_FORMAT, "its leading planes end outside it");
    return RMAP_OK;
}

enum rmap_status rmap_decoder_planes(struct rmap_decoder *decoder, uint8_t *stored,
                                     const struct rmap_stream_size *size, size_t n,
                                     size_t element_nbytes, uint8_t *plane, struct rmap_error *err)
{
    static const uint8_t final_block[2] = {0x03, 0x00}; /* empty, RFC 1951 3.2.6 */
    enum rmap_status st = check_stored(stored, size, element_nbytes, err);
    if (st != RMAP_OK)
        return st;
    size_t lead = element_nbytes, nbytes = size->nbytes - HEADER;
    if (size->lead_planes < element_nbytes) {
        lead = size->lead_planes;
        nbytes = size->lead_nbytes - HEADER + sizeof final_block;
        memcpy(stored + size->lead_nbytes, final_block, sizeof final_block);
    }
    /* fletcher32 vouches for all that was stored: Adler-32 need not be computed once more. */
    if (lead > 0 && !rmap_inflate(decoder->inflater, stored + HEADER, nbytes + RMAP_DECODER_SLACK,
                                  plane, n * lead))
        return rmap_error_set(err, RMAP_FORMAT, "no zlib stream of %zu bytes", n * lead);
    return RMAP_OK;
}

bool rmap_codec_repeats(const uint8_t *stored, const struct rmap_stream_size *size,
                        const void *element, size_t element_nbytes, size_t n_used, size_t n)
{
    const size_t end = ADLER + FLETCHER_NBYTES;
    return size->nbytes > end && n_used > 0 &&
           rmap_uniform_stream(stored, size->nbytes - end, element, element_nbytes, n_used,
                               n - n_used);
}
