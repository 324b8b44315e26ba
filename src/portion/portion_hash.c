/* SPDX-License-Identifier: MIT */
#include "portion/portion_hash.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

static struct rmap_digest hash(const void *data, size_t nbytes)
{
    XXH128_hash_t value = XXH3_128bits(data, nbytes);
    return (struct rmap_digest){value.low64, value.high64};
}

static uint64_t hash64(const void *data, size_t nbytes)
{
    return XXH3_64bits(data, nbytes);
}

rmap_hash_function *rmap_hash_fastest(void)
{
    rmap_hash_function *wide = rmap_hash_wide();
    return wide ? wide : hash;
}

rmap_hash64_function *rmap_hash64_fastest(void)
{
    rmap_hash64_function *wide = rmap_hash64_wide();
    return wide ? wide : hash64;
}
