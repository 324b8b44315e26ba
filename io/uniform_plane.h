/* SPDX-License-Identifier: MIT
 *
 * One byte over and over, as one deflate block (RFC 1951 3.2.7): two bits for every 258 of them.
 */
#ifndef RMAP_UNIFORM_PLANE_H
#define RMAP_UNIFORM_PLANE_H

#include <stddef.h>
#include <stdint.h>

/* Bytes that pay. */
#define RMAP_UNIFORM_MIN 1024

/* Writes the block, which is not the last one, and an empty stored block that ends at a byte.
 * nbytes >= RMAP_UNIFORM_MIN; `out` has room for as many. Length of both. */
size_t rmap_uniform_plane(uint8_t byte, size_t nbytes, uint8_t *out);

#endif
