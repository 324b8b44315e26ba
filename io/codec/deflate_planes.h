/* SPDX-License-Identifier: MIT
 *
 * One zlib stream (RFC 1950) of a chunk's byte planes, fast. With ISA-L each plane gets the
 * method that pays: stored, Huffman codes alone, or a search for matches. Without it libdeflate
 * does them all.
 */
#ifndef RMAP_DEFLATE_PLANES_H
#define RMAP_DEFLATE_PLANES_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

/* A stream's length and the way through it: from plane lead_planes on all bytes are 0, and the
 * planes before end after lead_nbytes bytes of the stream, at a byte and in a block that is not the
 * last. lead_planes = number of planes: no shortcut. */
struct rmap_stream_size {
    size_t nbytes;
    uint32_t lead_nbytes;
    uint16_t lead_planes;
};

/* How a plane of a stream was deflated, which is how that of its next chunks will be: looking at
 * each of them costs a tenth of writing them. All 0: not known yet. */
struct rmap_plane_habit {
    uint8_t method, n_left;
};

struct rmap_deflater;
enum rmap_status rmap_deflater_create(struct rmap_deflater **deflater_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;
void rmap_deflater_destroy(struct rmap_deflater *deflater);

/* Most bytes that n_plane planes of plane_nbytes can take. */
size_t rmap_deflate_bound(size_t n_plane, size_t plane_nbytes);

/* Writes the stream of planes of n_used + n_zero bytes, of which `plane` [n_plane][stride] has the
 * first n_used, and the others are 0; out has room for rmap_deflate_bound. habit: [n_plane], of
 * the chunks before, or NULL: the stream is the planes' alone. */
struct rmap_stream_size rmap_deflate_planes(struct rmap_deflater *deflater,
                                            struct rmap_plane_habit *habit, const uint8_t *plane,
                                            size_t stride, size_t n_plane, size_t n_used,
                                            size_t n_zero, uint8_t *out);

#endif
