/* SPDX-License-Identifier: MIT
 *
 * Hashes of rows of steps, many rows in one call. NH of UMAC (Black, Halevi, Krawczyk, Krovetz and
 * Rogaway 1999, doi:10.1007/3-540-48405-1_14): sums of products of pairs of words, each with a key
 * of its own added, three times with three sets of keys. Two different rows have three equal sums
 * for at most 2^-93 of all keys: each for 2^-32 of them, where one row is longer by a block for
 * 2^-31. The sums are mixed to 128 bits. The keys are constants.
 */
#ifndef RMAP_STEP_HASH_H
#define RMAP_STEP_HASH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    RMAP_STEP_HASH_BLOCK = 32,  /* bytes */
    RMAP_STEP_HASH_BLOCKS = 16, /* longer rows: XXH3 */
    RMAP_STEP_HASH_SETS = 3,
    /* Bytes behind the last row that may be read. */
    RMAP_STEP_HASH_BEHIND = RMAP_STEP_HASH_BLOCK
};

struct rmap_step_hash_keys {
    uint32_t key[RMAP_STEP_HASH_BLOCKS][RMAP_STEP_HASH_SETS][RMAP_STEP_HASH_BLOCK / 4];
};
void rmap_step_hash_keys_init(struct rmap_step_hash_keys *keys);

/* Rows of steps, one behind the other or not: row i is of count[i] steps from first[i] on. */
struct rmap_step_rows {
    const void *steps;
    bool is_narrow;                /* steps have 2 bytes, else 4 */
    const uint32_t *first, *count; /* [n] */
    size_t n;
};

/* Of row i: low[i] and high[i]. */
void rmap_step_hash_rows(const struct rmap_step_hash_keys *keys, const struct rmap_step_rows *rows,
                         uint64_t *low, uint64_t *high);

/* The same, a word at a time: what tests compare it with. */
void rmap_step_hash_rows_plain(const struct rmap_step_hash_keys *keys,
                               const struct rmap_step_rows *rows, uint64_t *low, uint64_t *high);

#endif
