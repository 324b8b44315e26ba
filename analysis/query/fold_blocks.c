/* SPDX-License-Identifier: MIT
 *
 * States of folds as bytes for another rank, and from them.
 */
#include "analysis/query/fold_blocks.h"

#include <string.h>

#include "analysis/query/fold.h"
#include "base/alloc.h"

static size_t total(const struct rmap_fold_block *block, size_t n)
{
    size_t sum = 0;
    for (size_t i = 0; i < n; i++)
        sum += block[i].nbytes;
    return sum;
}

enum rmap_status rmap_fold_pack(const struct rmap_fold *fold, const void *state,
                                uint8_t **bytes_ret, size_t *nbytes_ret, struct rmap_error *err)
{
    struct rmap_fold_block block[RMAP_FOLD_BLOCKS_MAX];
    if (!fold->kind->blocks)
        return fold->kind->pack(state, bytes_ret, nbytes_ret, err);
    const size_t n = fold->kind->blocks(state, block), nbytes = total(block, n);
    uint8_t *at = rmap_alloc_unset(nbytes + 1, 1);
    if (!at)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu bytes of sums", nbytes);
    *bytes_ret = at;
    *nbytes_ret = nbytes;
    for (size_t i = 0; i < n; at += block[i++].nbytes)
        if (block[i].nbytes > 0)
            memcpy(at, block[i].data, block[i].nbytes);
    return RMAP_OK;
}

enum rmap_status rmap_fold_unpack(const struct rmap_fold *fold, const uint8_t *bytes, size_t nbytes,
                                  void **state_ret, struct rmap_error *err)
{
    struct rmap_fold_block block[RMAP_FOLD_BLOCKS_MAX];
    *state_ret = NULL;
    if (!fold->kind->blocks)
        return fold->kind->unpack(fold->context, bytes, nbytes, state_ret, err);
    const enum rmap_status st = fold->kind->create(fold->context, state_ret, err);
    if (st != RMAP_OK)
        return st;
    const size_t n = fold->kind->blocks(*state_ret, block);
    if (nbytes != total(block, n))
        return rmap_error_set(err, RMAP_INTERNAL, "sums of another rank have %zu bytes", nbytes);
    for (size_t i = 0; i < n; bytes += block[i++].nbytes)
        if (block[i].nbytes > 0)
            memcpy(block[i].data, bytes, block[i].nbytes);
    return RMAP_OK;
}
