/* SPDX-License-Identifier: MIT
 *
 * Huffman codes of 64 bytes at a time, where the machine looks 64 bytes up in a table of 256 by a
 * few instructions (AVX-512 VBMI).
 */
#ifndef RMAP_HUFFMAN_WIDE_H
#define RMAP_HUFFMAN_WIDE_H

#include "io/file/bit_writer.h"

/* Writes the codes of the first bytes, value[byte] of length[byte] <= 14 bits, and returns of how
 * many: the multiple of 64 that n has, or 0 where the machine cannot. */
size_t rmap_huffman_wide(const uint32_t value[256], const uint32_t length[256], const uint8_t *data,
                         size_t n, struct rmap_bits *bits);

#endif
