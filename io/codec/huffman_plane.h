/* SPDX-License-Identifier: MIT
 *
 * Bytes without repetitions worth a search, as one deflate block (RFC 1951 3.2.7) of Huffman codes
 * for literals alone. ISA-L always searches.
 */
#ifndef RMAP_HUFFMAN_PLANE_H
#define RMAP_HUFFMAN_PLANE_H

#include <stddef.h>
#include <stdint.h>

/* Writes the block, which is not the last one, and an empty stored block that ends at a byte.
 * nbytes > 0. Length of both, or 0 when they do not fit in out_cap bytes. */
size_t rmap_huffman_plane(const uint8_t *data, size_t nbytes, uint8_t *out, size_t out_cap);

#endif
