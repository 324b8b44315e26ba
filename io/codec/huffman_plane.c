/* SPDX-License-Identifier: MIT */
#include "io/codec/huffman_plane.h"

#include <stdbool.h>
#include <string.h>

#include "base/wide.h"
#include "io/codec/huffman_wide.h"
#include "io/file/bit_writer.h"

enum {
    END = 256, /* symbol that ends a block */
    SYMBOLS = 257,
    LENGTH_MAX = 14, /* four codes and 7 bits that are left over fit into 64 */
    LITERALS_AT_ONCE = 4
};

struct code {
    uint8_t length[SYMBOLS];
    uint32_t value[SYMBOLS]; /* its first bit the lowest */
    uint32_t n[SYMBOLS];     /* length */
};

/* Equal bytes in a row do not wait for each other. */
static void count(const uint8_t *data, size_t nbytes, uint32_t total[SYMBOLS])
{
    enum { PARTS = sizeof(uint64_t) };
    uint32_t part[PARTS][256] = {{0}};
    size_t i = 0;
    for (; i + PARTS <= nbytes; i += PARTS) {
        uint64_t bytes;
        memcpy(&bytes, data + i, sizeof bytes);
        for (size_t k = 0; k < PARTS; k++)
            part[k][bytes >> (8 * k) & 255]++;
    }
    for (; i < nbytes; i++)
        part[0][data[i]]++;
    for (size_t s = 0; s < 256; s++) {
        total[s] = 0;
        for (size_t k = 0; k < PARTS; k++)
            total[s] += part[k][s];
    }
    total[END] = 1;
}

/* Symbols that occur, rarest first; how many. By counting 9 bits of their number, twice. */
static int sort(const uint32_t total[SYMBOLS], uint16_t symbol[SYMBOLS], uint32_t weight[SYMBOLS])
{
    enum { BITS = 9, KEYS = 1 << BITS };
    uint16_t other[SYMBOLS];
    uint32_t most = 0;
    int n = 0, shift = 0;
    for (int s = 0; s < SYMBOLS; s++)
        most = total[s] > most ? total[s] : most;
    while (most >> shift >> (2 * BITS))
        shift++;
    for (int s = 0; s < SYMBOLS; s++) {
        weight[s] = total[s] >> shift > 0 ? total[s] >> shift : total[s] > 0;
        if (weight[s] > 0)
            other[n++] = (uint16_t)s;
    }
    for (int pass = 0; pass < 2; pass++) {
        const uint16_t *from = pass ? symbol : other;
        uint16_t copy[SYMBOLS], *to = pass ? copy : symbol;
        uint16_t first[KEYS + 1] = {0};
        for (int i = 0; i < n; i++)
            first[(weight[from[i]] >> (BITS * pass) & (KEYS - 1)) + 1]++;
        for (int k = 0; k < KEYS; k++)
            first[k + 1] = (uint16_t)(first[k + 1] + first[k]);
        for (int i = 0; i < n; i++)
            to[first[weight[from[i]] >> (BITS * pass) & (KEYS - 1)]++] = from[i];
        if (pass)
            memcpy(symbol, copy, (size_t)n * sizeof *symbol);
    }
    return n;
}

/* Depths of the n - 1 inner nodes of the Huffman tree over weights in rising order; the last is
 * the root. Leaves and inner nodes are two queues, both in rising order. */
static void find_depths(const uint16_t *symbol, const uint32_t *weight, int n, uint8_t *depth)
{
    uint64_t sum[SYMBOLS];
    uint16_t parent[SYMBOLS];
    int leaf = 0, node = 0;
    for (int made = 0; made < n - 1; made++) {
        sum[made] = 0;
        for (int side = 0; side < 2; side++) {
            bool take_leaf = leaf < n && (node == made || weight[symbol[leaf]] <= sum[node]);
            sum[made] += take_leaf ? weight[symbol[leaf]] : sum[node];
            if (take_leaf)
                leaf++;
            else
                parent[node++] = (uint16_t)made;
        }
    }
    depth[n - 2] = 0;
    for (int i = n - 3; i >= 0; i--)
        depth[i] = (uint8_t)(depth[parent[i]] < 255 ? depth[parent[i]] + 1 : 255);
}

/* Lengths of a complete code. The tree is built from its root: each inner node divides a leaf at
 * its own depth, or, where that is too deep, the deepest one that may be divided. */
static void find_lengths(const uint32_t total[SYMBOLS], uint8_t length[SYMBOLS])
{
    uint16_t symbol[SYMBOLS];
    uint32_t weight[SYMBOLS];
    uint8_t depth[SYMBOLS];
    uint16_t leaves[LENGTH_MAX + 1] = {1};
    int n = sort(total, symbol, weight);
    find_depths(symbol, weight, n, depth);
    for (int i = n - 2; i >= 0; i--) {
        int at = depth[i] < LENGTH_MAX ? depth[i] : LENGTH_MAX - 1;
        while (leaves[at] == 0)
            at--;
        leaves[at]--;
        leaves[at + 1] = (uint16_t)(leaves[at + 1] + 2);
    }
    memset(length, 0, SYMBOLS);
    for (int bits = LENGTH_MAX, i = 0; bits > 0; bits--)
        for (; leaves[bits] > 0; leaves[bits]--)
            length[symbol[i++]] = (uint8_t)bits;
}

/* Canonical codes (RFC 1951 3.2.2). */
static void assign(struct code *code)
{
    uint32_t n[LENGTH_MAX + 1] = {0}, next[LENGTH_MAX + 2] = {0};
    for (int s = 0; s < SYMBOLS; s++)
        n[code->length[s]]++;
    n[0] = 0;
    for (int bits = 0; bits <= LENGTH_MAX; bits++)
        next[bits + 1] = (next[bits] + n[bits]) << 1;
    for (int s = 0; s < SYMBOLS; s++) {
        uint32_t bits = code->length[s], value = bits ? next[bits]++ : 0;
        code->value[s] = rmap_bits_turned(value, bits);
        code->n[s] = bits;
    }
}

/* The lengths of the codes are themselves coded by 4 bits each, whatever they are. */
static void put_header(struct rmap_bits *bits, const uint8_t length[SYMBOLS])
{
    enum { LENGTH_CODES = 19, USED_FROM = 3, FLAT = 4 };
    rmap_bits_put(bits, 4, 3); /* not the last block; codes of its own */
    rmap_bits_put(bits, 0, 5); /* 257 literals */
    rmap_bits_put(bits, 0, 5); /* 1 distance, which has no code */
    rmap_bits_put(bits, LENGTH_CODES - 4, 4);
    for (int i = 0; i < LENGTH_CODES; i++) /* 16, 17, 18, then 0 to 15 in some order */
        rmap_bits_put(bits, i < USED_FROM ? 0 : FLAT, 3);
    for (int s = 0; s <= SYMBOLS; s++) {
        uint32_t v = s < SYMBOLS ? length[s] : 0;
        rmap_bits_put(bits, (v & 1) << 3 | (v & 2) << 1 | (v & 4) >> 1 | v >> 3, FLAT);
    }
}

static size_t block_nbytes(const uint32_t total[SYMBOLS], const uint8_t length[SYMBOLS])
{
    enum { HEADER_BITS = 3 + 5 + 5 + 4 + 19 * 3 + (SYMBOLS + 1) * 4, STORED_NBYTES = 5 };
    uint64_t n_bit = HEADER_BITS + 3;
    for (int s = 0; s < SYMBOLS; s++)
        n_bit += (uint64_t)total[s] * length[s];
    return (size_t)((n_bit + 7) / 8) + STORED_NBYTES;
}

RMAP_WIDE_SHIFTS
static void put_literals(struct rmap_bits *bits, const struct code *code, const uint8_t *data,
                         size_t nbytes)
{
    struct rmap_bits local = *bits; /* in registers: `out` may point anywhere */
    const uint32_t *value = code->value, *length = code->n;
    size_t i = rmap_huffman_wide(value, length, data, nbytes, &local);
    for (; i + LITERALS_AT_ONCE <= nbytes; i += LITERALS_AT_ONCE) {
        size_t a = data[i], b = data[i + 1], c = data[i + 2], d = data[i + 3];
        uint64_t ab = value[a] | (uint64_t)value[b] << length[a];
        uint64_t cd = value[c] | (uint64_t)value[d] << length[c];
        unsigned n_ab = length[a] + length[b], n_cd = length[c] + length[d];
        rmap_bits_put(&local, ab | cd << n_ab, n_ab + n_cd);
    }
    for (; i < nbytes; i++)
        rmap_bits_put(&local, value[data[i]], length[data[i]]);
    *bits = local;
}

size_t rmap_huffman_plane(const uint8_t *data, size_t nbytes, uint8_t *out, size_t out_cap)
{
    uint32_t total[SYMBOLS];
    struct code code;
    struct rmap_bits bits = {.out = out};
    count(data, nbytes, total);
    find_lengths(total, code.length);
    if (block_nbytes(total, code.length) + sizeof bits.waiting > out_cap)
        return 0;
    assign(&code);
    put_header(&bits, code.length);
    put_literals(&bits, &code, data, nbytes);
    rmap_bits_put(&bits, code.value[END], code.n[END]);
    return (size_t)(rmap_bits_align(&bits) - out);
}
