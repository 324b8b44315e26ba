/* SPDX-License-Identifier: MIT
 *
 * States that are some arrays of a known length, as bytes for another rank, and from them.
 */
#include "analysis/query/fold_blocks.h"

#include <string.h>

#include "base/alloc.h"

static size_t total(const struct rmap_fold_block *block, size_t n)
{
    size_t sum = 0;
    for (size_t i = 0; i < n; i++)
        sum += block[i].nbytes;
    return sum;
}

enum rmap_status rmap_fold_pack(const struct rmap_fold_block *block, size_t n, uint8_t **bytes_ret,
                                size_t *nbytes_ret, struct rmap_error *err)
{
    const size_t nbytes = total(block, n);
    uint8_t *at = rmap_alloc(nbytes + 1, 1);
    if (!at)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu bytes of sums", nbytes);
    *bytes_ret = at;
    *nbytes_ret = nbytes;
    for (size_t i = 0; i < n; at += block[i++].nbytes)
        if (block[i].nbytes > 0)
            memcpy(at, block[i].data, block[i].nbytes);
    return RMAP_OK;
}

enum rmap_status rmap_fold_unpack(const struct rmap_fold_block *block, size_t n,
                                  const uint8_t *bytes, size_t nbytes, struct rmap_error *err)
{
    if (nbytes != total(block, n))
        return rmap_error_set(err, RMAP_INTERNAL, "sums of another rank have %zu bytes", nbytes);
    for (size_t i = 0; i < n; bytes += block[i++].nbytes)
        if (block[i].nbytes > 0)
            memcpy(block[i].data, bytes, block[i].nbytes);
    return RMAP_OK;
}
