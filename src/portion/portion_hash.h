/* SPDX-License-Identifier: MIT
 *
 * XXH3 with the vectors that the machine has: the library's inline functions take those that
 * the compiler was told of.
 */
#ifndef RMAP_PORTION_HASH_H
#define RMAP_PORTION_HASH_H

#include <stddef.h>

#include "portion/portion.h"

/* XXH3-128, XXH3-64. */
typedef struct rmap_digest rmap_hash_function(const void *data, size_t nbytes);
typedef uint64_t rmap_hash64_function(const void *data, size_t nbytes);

/* Both give the same; wide: NULL where it cannot be had. */
rmap_hash_function *rmap_hash_wide(void);
rmap_hash_function *rmap_hash_fastest(void);
rmap_hash64_function *rmap_hash64_wide(void);
rmap_hash64_function *rmap_hash64_fastest(void);

#endif
