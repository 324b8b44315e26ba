/* SPDX-License-Identifier: MIT
 *
 * Bits of a deflate stream (RFC 1951), the lowest first.
 */
#ifndef RMAP_BIT_WRITER_H
#define RMAP_BIT_WRITER_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* Bits waiting for a whole byte: n < 8. */
struct rmap_bits {
    uint64_t waiting;
    unsigned n;
    uint8_t *out;
};

/* At most 56 bits; 8 bytes at `out` may be written. */
static inline void rmap_bits_put(struct rmap_bits *bits, uint64_t value, unsigned n)
{
    bits->waiting |= value << bits->n;
    bits->n += n;
    memcpy(bits->out, &bits->waiting, sizeof bits->waiting);
    bits->out += bits->n >> 3;
    bits->waiting >>= bits->n & 56;
    bits->n &= 7;
}

/* A Huffman code, whose first bit is its highest (RFC 1951 3.1.1), the other way round. */
static inline uint32_t rmap_bits_turned(uint32_t code, unsigned n)
{
    uint32_t turned = 0;
    for (unsigned k = 0; k < n; k++)
        turned |= (code >> k & 1) << (n - 1 - k);
    return turned;
}

/* An empty stored block, which is not the last one, up to the next byte. Returns its end. */
static inline uint8_t *rmap_bits_align(struct rmap_bits *bits)
{
    static const uint8_t empty[4] = {0, 0, 0xff, 0xff};
    rmap_bits_put(bits, 0, 3);
    if (bits->n > 0)
        rmap_bits_put(bits, 0, 8 - bits->n);
    memcpy(bits->out, empty, sizeof empty);
    return bits->out + sizeof empty;
}

#endif
