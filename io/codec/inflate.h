/* SPDX-License-Identifier: MIT
 *
 * Raw deflate streams (RFC 1951) of known length, with the decoder that is fastest for them.
 */
#ifndef RMAP_INFLATE_H
#define RMAP_INFLATE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

struct rmap_inflater;
enum rmap_status rmap_inflater_create(struct rmap_inflater **inflater_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;
void rmap_inflater_destroy(struct rmap_inflater *inflater);

/* Bytes before the end of `in` that are read but need not belong to the stream make it faster.
 * False unless the stream ends properly and gives exactly n_out bytes. */
bool rmap_inflate(struct rmap_inflater *inflater, const uint8_t *in, size_t n_in, uint8_t *out,
                  size_t n_out);

#endif
