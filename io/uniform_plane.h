/* SPDX-License-Identifier: MIT
 *
 * One byte over and over, as one deflate block (RFC 1951 3.2.7): two bits for every 258 of them.
 */
#ifndef RMAP_UNIFORM_PLANE_H
#define RMAP_UNIFORM_PLANE_H

#include <stddef.h>
#include <stdint.h>

/* So many bytes pay; what few take at most. */
#define RMAP_UNIFORM_MIN   1024
#define RMAP_UNIFORM_BOUND 96

/* Writes the block, which is not the last one, and an empty stored block that ends at a byte.
 * nbytes > 0; `out` has room for RMAP_UNIFORM_BOUND and an eighth of nbytes. Length of both. */
size_t rmap_uniform_plane(uint8_t byte, size_t nbytes, uint8_t *out);

#endif
