/* SPDX-License-Identifier: MIT
 *
 * Mantissa planes have no matches: searching for them is wasted time, and where the bytes are
 * noise even Huffman codes are. So each plane becomes deflate blocks of its own, byte-aligned by
 * a full flush, chosen from samples of the plane, or as in the stream's chunks before:
 *   stored          where the sample's entropy is nearly that of noise,
 *   literals        Huffman codes alone, without any search (huffman_plane.c),
 *   matches         where a sample shrinks well more with them: object ids, events, counts;
 * and what is one byte over and over to the plane's end a block that needs no look at it
 * (uniform_plane.c): high bytes of small numbers, and what is left of a last chunk.
 */
#ifdef RAYMAP_HAVE_ISAL

#include "io/codec/deflate_planes.h"

#include <isa-l/igzip_lib.h>
#include <libdeflate.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "base/alloc.h"
#include "io/codec/huffman_plane.h"
#include "io/codec/igzip_stream.h"
#include "io/codec/uniform_plane.h"

/* 4096 bytes of pure noise show 7.95 bits each (8 - 255 / (2 x 4096 ln 2)); above this limit
 * Huffman codes gain under a tenth, which costs more time than it saves to write and read. */
#define SAMPLE_NBYTES 4096
#define SAMPLE_PIECES 8
#define NOISE_BITS    7.1

/* A search must make a sample this much smaller than its entropy says to be worth its time. */
#define WINDOW_SAMPLE_NBYTES 8192
#define WINDOW_GAIN          0.85

/* Where a search is in vain, it takes longest: a short look at a quarter of that sample tells when
 * it makes it no smaller at all. */
#define GLANCE_NBYTES 2048
#define GLANCE_GAIN   1.0

/* Above so many bits per byte no search pays. */
#define LITERAL_BITS 6.5

#define STORED_MAX 65535 /* bytes of one stored block, RFC 1951 3.2.4 */

struct rmap_deflater {
    struct isal_zstream *stream;
    uint8_t level_buffer[ISAL_DEF_LVL1_DEFAULT];
    uint8_t sample[2 * WINDOW_SAMPLE_NBYTES];
};

enum rmap_status rmap_deflater_create(struct rmap_deflater **deflater_ret, struct rmap_error *err)
{
    struct rmap_deflater *deflater = rmap_alloc(1, sizeof *deflater);
    if (deflater)
        deflater->stream = rmap_igzip_stream_create(deflater);
    if (!deflater || !deflater->stream) {
        rmap_free(deflater);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a compressor");
    }
    *deflater_ret = deflater;
    return RMAP_OK;
}

void rmap_deflater_destroy(struct rmap_deflater *deflater)
{
    if (!deflater)
        return;
    rmap_igzip_stream_destroy(deflater->stream);
    rmap_free(deflater);
}

static size_t stored_nbytes(size_t nbytes)
{
    return nbytes + 5 * ((nbytes + STORED_MAX - 1) / STORED_MAX);
}

size_t rmap_deflate_bound(size_t n_plane, size_t plane_nbytes)
{
    enum { HEADER = 2, ZEROS = 2 * RMAP_UNIFORM_BOUND, FINAL_BLOCK = 2, ADLER = 4 };
    return HEADER + n_plane * (stored_nbytes(plane_nbytes) + ZEROS) + FINAL_BLOCK + ADLER;
}

static size_t put_stored(const uint8_t *data, size_t nbytes, uint8_t *out)
{
    uint8_t *p = out;
    while (nbytes > 0) {
        size_t n = nbytes < STORED_MAX ? nbytes : STORED_MAX;
        const uint8_t header[5] = {0, (uint8_t)(n & 255), (uint8_t)(n >> 8), (uint8_t)(~n & 255),
                                   (uint8_t)(~n >> 8 & 255)};
        memcpy(p, header, sizeof header);
        memcpy(p + sizeof header, data, n);
        p += sizeof header + n;
        data += n;
        nbytes -= n;
    }
    return (size_t)(p - out);
}

/* Length of the blocks written, or 0 when they do not fit in out_cap bytes. */
static size_t put_matched(struct rmap_deflater *deflater, const uint8_t *data, size_t nbytes,
                          uint8_t *out, size_t out_cap)
{
    struct isal_zstream *stream = deflater->stream;
    union {
        const uint8_t *in;
        uint8_t *next_in;
    } source = {.in = data}; /* ISA-L's field lacks the const that it keeps */
    isal_deflate_stateless_init(stream);
    stream->level = 1;
    stream->level_buf = deflater->level_buffer;
    stream->level_buf_size = sizeof deflater->level_buffer;
    stream->flush = FULL_FLUSH;
    stream->end_of_stream = 0;
    stream->next_in = source.next_in;
    stream->avail_in = (uint32_t)nbytes;
    stream->next_out = out;
    stream->avail_out = (uint32_t)out_cap;
    if (isal_deflate_stateless(stream) != COMP_OK || stream->avail_in != 0)
        return 0;
    return out_cap - stream->avail_out;
}

/* Shannon entropy per byte of a sample spread over the plane. */
static double sample_bits(const uint8_t *data, size_t nbytes)
{
    uint32_t count[256] = {0};
    size_t n = 0, piece = SAMPLE_NBYTES / SAMPLE_PIECES;
    size_t pieces = nbytes <= SAMPLE_NBYTES ? 1 : SAMPLE_PIECES;
    if (pieces == 1)
        piece = nbytes;
    for (size_t k = 0; k < pieces; k++) {
        const uint8_t *p = data + (pieces > 1 ? k * ((nbytes - piece) / (pieces - 1)) : 0);
        for (size_t i = 0; i < piece; i++)
            count[p[i]]++;
        n += piece;
    }
    double bits = 0.0;
    for (int i = 0; i < 256; i++)
        if (count[i])
            bits -= count[i] * log2((double)count[i] / (double)n);
    return n ? bits / (double)n : 0.0;
}

/* Bytes at the end that are all the same, as far as steps find them. */
static size_t uniform_end(const uint8_t *data, size_t nbytes)
{
    enum { STEP = 1024 };
    size_t start = nbytes - 1;
    for (size_t n; start > 0; start -= n) {
        n = start < STEP ? start : STEP;
        if (memcmp(data + start - n, data + start - n + 1, n) != 0)
            break;
    }
    return nbytes - start;
}

static bool is_zero(const uint8_t *data, size_t nbytes)
{
    return nbytes == 0 || (data[nbytes - 1] == 0 && uniform_end(data, nbytes) == nbytes);
}

/* Whether a search makes n bytes in the middle of the plane so much smaller than their entropy
 * says: gain is the quotient. */
static bool shrinks(struct rmap_deflater *deflater, const uint8_t *data, size_t nbytes, size_t n,
                    double bits, double gain)
{
    const uint8_t *middle = data + (nbytes - n) / 2;
    size_t matched = put_matched(deflater, middle, n, deflater->sample, sizeof deflater->sample);
    double literal = bits > 1.0 ? bits : 1.0; /* no code is shorter */
    return 8.0 * (double)matched < gain * literal * (double)n;
}

/* Is a search for matches worth its time? */
static bool has_matches(struct rmap_deflater *deflater, const uint8_t *data, size_t nbytes,
                        double bits)
{
    size_t n = nbytes < WINDOW_SAMPLE_NBYTES ? nbytes : WINDOW_SAMPLE_NBYTES;
    if (bits > LITERAL_BITS)
        return false;
    return (n <= 2 * GLANCE_NBYTES ||
            shrinks(deflater, data, nbytes, GLANCE_NBYTES, bits, GLANCE_GAIN)) &&
           shrinks(deflater, data, nbytes, n, bits, WINDOW_GAIN);
}

enum method { STORED, LITERALS, MATCHES };

static enum method choose(struct rmap_deflater *deflater, const uint8_t *data, size_t nbytes)
{
    double bits = sample_bits(data, nbytes);
    if (nbytes >= SAMPLE_NBYTES && bits >= NOISE_BITS)
        return STORED;
    return has_matches(deflater, data, nbytes, bits) ? MATCHES : LITERALS;
}

/* Every so many chunks of a stream the choice is made anew. */
#define HABIT_CHUNKS 8

static enum method choose_as_before(struct rmap_deflater *deflater, struct rmap_plane_habit *habit,
                                    const uint8_t *data, size_t nbytes)
{
    if (habit->n_left == 0) {
        habit->method = (uint8_t)choose(deflater, data, nbytes);
        habit->n_left = HABIT_CHUNKS;
    }
    habit->n_left--;
    return (enum method)habit->method;
}

static size_t put_varied(struct rmap_deflater *deflater, struct rmap_plane_habit *habit,
                         const uint8_t *data, size_t nbytes, uint8_t *out)
{
    size_t stored = stored_nbytes(nbytes), coded = 0;
    enum method method =
        habit ? choose_as_before(deflater, habit, data, nbytes) : choose(deflater, data, nbytes);
    if (method == MATCHES)
        coded = put_matched(deflater, data, nbytes, out, stored);
    else if (method == LITERALS)
        coded = rmap_huffman_plane(data, nbytes, out, stored);
    return coded ? coded : put_stored(data, nbytes, out);
}

/* One plane: n_used bytes, then n_zero that are 0. */
static size_t put_plane(struct rmap_deflater *deflater, struct rmap_plane_habit *habit,
                        const uint8_t *data, size_t n_used, size_t n_zero, uint8_t *out)
{
    size_t n_same = n_used > 0 ? uniform_end(data, n_used) : 0;
    uint8_t same = n_used > 0 ? data[n_used - 1] : 0;
    uint8_t *p = out;
    if (n_same < RMAP_UNIFORM_MIN && n_same < n_used)
        n_same = 0;
    if (n_same < n_used)
        p += put_varied(deflater, habit, data, n_used - n_same, p);
    if (n_same > 0 && same == 0)
        n_zero += n_same;
    else if (n_same > 0)
        p += rmap_uniform_plane(same, n_same, p);
    if (n_zero > 0)
        p += rmap_uniform_plane(0, n_zero, p);
    return (size_t)(p - out);
}

/* Adler-32 (RFC 1950) with one plane more. */
static uint32_t adler_add(uint32_t adler, const uint8_t *plane, size_t n_used, size_t n_zero)
{
    const uint64_t base = 65521;
    adler = libdeflate_adler32(adler, plane, n_used);
    uint64_t low = adler & 0xffff, high = adler >> 16;
    high = (high + n_zero % base * low) % base;
    return (uint32_t)(high << 16 | low);
}

struct rmap_stream_size rmap_deflate_planes(struct rmap_deflater *deflater,
                                            struct rmap_plane_habit *habit, const uint8_t *plane,
                                            size_t stride, size_t n_plane, size_t n_used,
                                            size_t n_zero, uint8_t *out)
{
    static const uint8_t header[2] = {0x78, 0x01}, final_block[2] = {0x03, 0x00};
    uint32_t adler = 1;
    uint8_t *p = out;
    memcpy(p, header, sizeof header);
    p += sizeof header;
    size_t lead = n_plane;
    while (lead > 0 && is_zero(plane + (lead - 1) * stride, n_used))
        lead--;
    struct rmap_stream_size size = {.lead_planes = (uint16_t)lead};
    for (size_t k = 0; k < n_plane; k++) {
        if (k == lead)
            size.lead_nbytes = (uint32_t)(p - out);
        const uint8_t *data = plane + k * stride;
        p += put_plane(deflater, habit ? &habit[k] : NULL, data, n_used, n_zero, p);
        adler = adler_add(adler, data, n_used, n_zero); /* while it is in a cache */
    }
    memcpy(p, final_block, sizeof final_block);
    p += sizeof final_block;
    for (int shift = 24; shift >= 0; shift -= 8)
        *p++ = (uint8_t)(adler >> shift & 255);
    size.nbytes = (size_t)(p - out);
    return size;
}

#else
typedef int rmap_deflate_planes_isal_is_absent; /* a file must hold something */
#endif
