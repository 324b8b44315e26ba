/* SPDX-License-Identifier: MIT
 *
 * One byte over and over, as one deflate block (RFC 1951 3.2.7): two bits for every 258 of them.
 */
#ifndef RMAP_UNIFORM_PLANE_H
#define RMAP_UNIFORM_PLANE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* So many bytes pay; what few take at most. */
#define RMAP_UNIFORM_MIN   1024
#define RMAP_UNIFORM_BOUND 96

/* Writes the block, which is not the last one, and an empty stored block that ends at a byte.
 * nbytes > 0; `out` has room for RMAP_UNIFORM_BOUND and an eighth of nbytes. Length of both. */
size_t rmap_uniform_plane(uint8_t byte, size_t nbytes, uint8_t *out);

/* Whether a zlib stream of nbytes bytes, without its Adler-32, is what planes become of which each
 * is byte[k] n_used times, then 0 n_zero times: told by its bytes, not by inflating it. False of a
 * stream that another encoder made, whatever is in it. n_used > 0. */
bool rmap_uniform_stream(const uint8_t *stream, size_t nbytes, const uint8_t *byte, size_t n_plane,
                         size_t n_used, size_t n_zero);

#endif
