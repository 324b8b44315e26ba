/* SPDX-License-Identifier: MIT
 *
 * A stored chunk from a stranger: decoding ends in planes of exactly their size or in RMAP_FORMAT.
 * The input is {u8 log2 of the element's bytes; u8 flags; u16 elements; the stored
 * bytes}. Flag 1 makes fletcher32 right again, so that what lies behind
 * that check is reached; flag 2 takes the bytes as rows to encode instead, which must come back.
 */
#include <string.h>

#include "base/alloc.h"
#include "io/codec/codec.h"
#include "io/codec/shuffle.h"
#include "target.h"

const unsigned rmap_fuzz_rounds = 8000;

enum { REPAIR = 1, ENCODE = 2 };

struct head {
    uint8_t log2_element, flags;
    uint16_t n;
};

static void take_head(const uint8_t **data, size_t *nbytes, struct head *head)
{
    rmap_fuzz_take(data, nbytes, &head->log2_element, 1);
    rmap_fuzz_take(data, nbytes, &head->flags, 1);
    rmap_fuzz_take(data, nbytes, &head->n, 2);
    head->log2_element %= 4;
}

static size_t encode(const void *raw, size_t n, size_t element, uint8_t *stored)
{
    struct rmap_encoder *encoder = NULL;
    struct rmap_error err = {0};
    size_t nbytes = 0;
    rmap_fuzz_demand(rmap_encoder_create(&encoder, &err) == RMAP_OK &&
                         rmap_encoder_encode(encoder, raw, n, n, element, stored, &nbytes, &err) ==
                             RMAP_OK,
                     "encoding");
    rmap_encoder_destroy(encoder);
    return nbytes;
}

static enum rmap_status decode(const uint8_t *stored, size_t nbytes, size_t n, size_t element,
                               uint8_t *plane)
{
    struct rmap_decoder *decoder = NULL;
    struct rmap_error err = {0};
    rmap_fuzz_demand(rmap_decoder_create(&decoder, &err) == RMAP_OK, "a decoder");
    enum rmap_status st = rmap_decoder_planes(decoder, stored, nbytes, n, element, plane, &err);
    rmap_decoder_destroy(decoder);
    return st;
}

/* Rows are where their elements may lie, unlike the fuzzer's bytes behind their head. */
static void there_and_back(const uint8_t *data, size_t n, size_t element)
{
    uint8_t *raw = rmap_alloc(n, element);
    uint8_t *stored = rmap_alloc(rmap_codec_bound(n, element) + RMAP_INFLATE_SLACK, 1);
    uint8_t *plane = rmap_alloc(n, element), *back = rmap_alloc(n, element);
    rmap_fuzz_demand(raw && stored && plane && back, "memory");
    if (n > 0)
        memcpy(raw, data, n * element);
    size_t nbytes = encode(raw, n, element, stored);
    rmap_fuzz_demand(nbytes <= rmap_codec_bound(n, element), "the bound of an encoded chunk");
    rmap_fuzz_demand(decode(stored, nbytes, n, element, plane) == RMAP_OK, "decoding its own");
    rmap_unshuffle(plane, n, 0, n, element, back);
    rmap_fuzz_demand(memcmp(raw, back, n * element) == 0, "what was encoded comes back");
    rmap_free(raw);
    rmap_free(stored);
    rmap_free(plane);
    rmap_free(back);
}

static void foreign(const struct head *head, const uint8_t *data, size_t nbytes)
{
    size_t element = (size_t)1 << head->log2_element;
    uint8_t *stored = rmap_alloc(nbytes + RMAP_INFLATE_SLACK, 1);
    uint8_t *plane = rmap_alloc(head->n, element);
    rmap_fuzz_demand(stored && plane, "memory");
    if (nbytes > 0)
        memcpy(stored, data, nbytes);
    if ((head->flags & REPAIR) && nbytes >= 4) {
        uint32_t sum = rmap_fletcher32(stored, nbytes - 4);
        memcpy(stored + nbytes - 4, &sum, 4);
    }
    enum rmap_status st = decode(stored, nbytes, head->n, element, plane);
    rmap_fuzz_demand(st == RMAP_OK || st == RMAP_FORMAT, "status of a foreign chunk");
    rmap_free(stored);
    rmap_free(plane);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t nbytes)
{
    struct head head;
    int64_t live = rmap_alloc_live();
    take_head(&data, &nbytes, &head);
    size_t element = (size_t)1 << head.log2_element;
    if (head.flags & ENCODE)
        there_and_back(data, nbytes / element, element);
    else
        foreign(&head, data, nbytes);
    rmap_fuzz_demand(rmap_alloc_live() == live, "memory is given back");
    return 0;
}

/* Chunks of small numbers, of noise and of both, in every width; then the same rows to encode. */
size_t rmap_fuzz_seed(unsigned k, uint8_t *to, size_t cap)
{
    enum { N = 700, KINDS = 3, WIDTHS = 4 };
    static uint8_t raw[N * 8], stored[N * 16 + 4096];
    struct head head = {.log2_element = (uint8_t)(k % WIDTHS), .flags = REPAIR, .n = N};
    size_t element = (size_t)1 << head.log2_element, at = 0;
    unsigned kind = k / WIDTHS % KINDS;
    if (k >= 2 * KINDS * WIDTHS || cap < sizeof stored)
        return 0;
    for (size_t i = 0; i < N * element; i++)
        raw[i] = kind == 0 || (kind == 2 && i % element) ? i % element == 0 ? (uint8_t)(i / 32) : 0
                                                         : (uint8_t)(i * i * 2654435761u >> 13);
    const uint8_t *body = raw;
    size_t nbytes = N * element;
    if (k < KINDS * WIDTHS) {
        nbytes = encode(raw, N, element, stored);
        body = stored;
    } else {
        head.flags = ENCODE;
    }
    to[at++] = head.log2_element;
    to[at++] = head.flags;
    memcpy(to + at, &head.n, 2);
    memcpy(to + at + 2, body, nbytes);
    return at + 2 + nbytes;
}
