/* SPDX-License-Identifier: MIT
 *
 * The bytes of one stored chunk: HDF5's filters shuffle, deflate and fletcher32, computed by our
 * own threads so that HDF5's lock never sees them.
 */
#include "io/codec/codec.h"

#include <string.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "base/wide.h"
#include "io/codec/shuffle.h"
#include "io/codec/zlib_stream.h"

#define FLETCHER_NBYTES 4
#define LOOK            4096 /* bytes that tell how a chunk is deflated best */

struct rmap_encoder {
    struct rmap_deflater *deflater, *runs;
    uint8_t *plane;
    size_t plane_cap;
};

struct rmap_decoder {
    struct rmap_inflater *inflater;
};

uint64_t rmap_checksum(const void *data, size_t nbytes)
{
    return XXH3_64bits(data, nbytes);
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
    return rmap_deflate_bound(n * element_nbytes) + FLETCHER_NBYTES;
}

enum rmap_status rmap_encoder_create(struct rmap_encoder **encoder_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_encoder *encoder = rmap_alloc(1, sizeof *encoder);
    if (!encoder)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for an encoder");
    RMAP_TRY(rmap_deflater_create(false, &encoder->deflater, err));
    RMAP_TRY(rmap_deflater_create(true, &encoder->runs, err));
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
    rmap_deflater_destroy(encoder->runs);
    rmap_free(encoder->plane);
    rmap_free(encoder);
}

/* Whether deflate leaves too much of such bytes for them to be inflated again and again. */
static bool noise(size_t deflated, size_t nbytes)
{
    return 5 * deflated > 3 * nbytes;
}

size_t rmap_encoder_encode_planes(struct rmap_encoder *encoder, const uint8_t *plane, size_t n,
                                  size_t element_nbytes, unsigned how, uint8_t *stored)
{
    const size_t all = n * element_nbytes, look = all < LOOK ? all : LOOK;
    struct rmap_deflater *deflater = encoder->deflater;
    bool as_is = how & RMAP_ENCODE_QUICK &&
                 noise(rmap_deflate(deflater, plane + all - look, look, stored), look);
    size_t nbytes = 0;
    if (!as_is) {
        if (how & RMAP_ENCODE_RUNS && rmap_deflate(encoder->runs, plane, look, stored) <=
                                          rmap_deflate(deflater, plane, look, stored))
            deflater = encoder->runs;
        nbytes = rmap_deflate(deflater, plane, all, stored);
        as_is = how & RMAP_ENCODE_QUICK && noise(nbytes, all);
    }
    if (as_is)
        nbytes = rmap_deflate_none(plane, all, stored);
    uint32_t sum = rmap_fletcher32(stored, nbytes);
    memcpy(stored + nbytes, &sum, FLETCHER_NBYTES);
    return nbytes + FLETCHER_NBYTES;
}

enum rmap_status rmap_encoder_encode(struct rmap_encoder *encoder, const void *raw, size_t n_used,
                                     size_t n, size_t element_nbytes, uint8_t *stored,
                                     size_t *nbytes_ret, struct rmap_error *err)
{
    enum rmap_status st =
        RMAP_RESERVE(encoder->plane, encoder->plane_cap, n * element_nbytes + 1, err);
    if (st != RMAP_OK)
        return st;
    rmap_shuffle(raw, n_used, element_nbytes, encoder->plane, n);
    for (size_t k = 0; k < element_nbytes; k++)
        memset(encoder->plane + k * n + n_used, 0, n - n_used);
    *nbytes_ret = rmap_encoder_encode_planes(encoder, encoder->plane, n, element_nbytes, 0, stored);
    return RMAP_OK;
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

enum rmap_status rmap_decoder_planes(struct rmap_decoder *decoder, const uint8_t *stored,
                                     size_t nbytes, size_t n, size_t element_nbytes, uint8_t *plane,
                                     struct rmap_error *err)
{
    uint32_t sum;
    if (nbytes < FLETCHER_NBYTES)
        return rmap_error_set(err, RMAP_FORMAT, "%zu bytes are no chunk", nbytes);
    size_t stream = nbytes - FLETCHER_NBYTES;
    memcpy(&sum, stored + stream, sizeof sum);
    if (sum != rmap_fletcher32(stored, stream))
        return rmap_error_set(err, RMAP_FORMAT, "fletcher32 does not match: the data are damaged");
    if (!rmap_inflate(decoder->inflater, stored, stream, plane, n * element_nbytes))
        return rmap_error_set(err, RMAP_FORMAT, "no zlib stream of %zu bytes", n * element_nbytes);
    return RMAP_OK;
}
