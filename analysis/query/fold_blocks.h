/* SPDX-License-Identifier: MIT
 *
 * States that are some arrays of a known length, as bytes for another rank, and from them.
 */
#ifndef RMAP_FOLD_BLOCKS_H
#define RMAP_FOLD_BLOCKS_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

struct rmap_fold_block {
    void *data; /* NULL: none */
    size_t nbytes;
};

/* *bytes_ret: rmap_free. RMAP_SYSTEM. */
enum rmap_status rmap_fold_pack(const struct rmap_fold_block *block, size_t n, uint8_t **bytes_ret,
                                size_t *nbytes_ret, struct rmap_error *err) RMAP_MUST_USE;

/* Fills the blocks. RMAP_INTERNAL when the bytes are of other ones. */
enum rmap_status rmap_fold_unpack(const struct rmap_fold_block *block, size_t n,
                                  const uint8_t *bytes, size_t nbytes,
                                  struct rmap_error *err) RMAP_MUST_USE;

#endif
