/* SPDX-License-Identifier: MIT */
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__OPTIMIZE__)
#pragma GCC target("avx2") /* of all that follows in this file */
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "portion/portion_hash.h"

static struct rmap_digest hash(const void *data, size_t nbytes)
{
    XXH128_hash_t value = XXH3_128bits(data, nbytes);
    return (struct rmap_digest){value.low64, value.high64};
}

static uint64_t hash64(const void *data, size_t nbytes)
{
    return XXH3_64bits(data, nbytes);
}

rmap_hash_function *rmap_hash_wide(void)
{
    return __builtin_cpu_supports("avx2") ? hash : NULL;
}

rmap_hash64_function *rmap_hash64_wide(void)
{
    return __builtin_cpu_supports("avx2") ? hash64 : NULL;
}
#else
#include "portion/portion_hash.h"

rmap_hash_function *rmap_hash_wide(void)
{
    return NULL;
}

rmap_hash64_function *rmap_hash64_wide(void)
{
    return NULL;
}
#endif
