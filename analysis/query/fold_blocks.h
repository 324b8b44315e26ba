/* SPDX-License-Identifier: MIT
 *
 * States of folds as bytes for another rank, and from them.
 */
#ifndef RMAP_FOLD_BLOCKS_H
#define RMAP_FOLD_BLOCKS_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

struct rmap_fold;

/* An array of a state. */
struct rmap_fold_block {
    void *data; /* NULL: none */
    size_t nbytes;
};
#define RMAP_FOLD_BLOCKS_MAX 16

/* By the kind's pack and unpack, or by its blocks. *bytes_ret: rmap_free. RMAP_SYSTEM;
 * RMAP_INTERNAL when the bytes are of other arrays. *state_ret is to be destroyed in any case, NULL
 * is fine. */
enum rmap_status rmap_fold_pack(const struct rmap_fold *fold, const void *state,
                                uint8_t **bytes_ret, size_t *nbytes_ret,
                                struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_fold_unpack(const struct rmap_fold *fold, const uint8_t *bytes, size_t nbytes,
                                  void **state_ret, struct rmap_error *err) RMAP_MUST_USE;

#endif
