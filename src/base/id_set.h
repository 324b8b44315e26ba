/* SPDX-License-Identifier: MIT
 *
 * A set of ray ids: at most a quarter of a byte per ray of the map, at most 16 bytes per id.
 */
#ifndef RMAP_ID_SET_H
#define RMAP_ID_SET_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

/* Ids 64 * word to 64 * word + 63, a bit each. */
struct rmap_id_word {
    uint64_t word, bits;
};

/* Zeroed: empty. */
struct rmap_id_set {
    struct rmap_id_word *at; /* [n], ascending once it is settled */
    size_t n, cap;
    bool is_unsettled;
};

void rmap_id_set_fini(struct rmap_id_set *set);

/* In any order; those of a portion in theirs is fastest. */
enum rmap_status rmap_id_set_add(struct rmap_id_set *set, uint64_t id,
                                 struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_id_set_add_words(struct rmap_id_set *set, const struct rmap_id_word *word,
                                       size_t n, struct rmap_error *err) RMAP_MUST_USE;

/* After adding, before the set is asked. */
void rmap_id_set_settle(struct rmap_id_set *set);

uint64_t rmap_id_set_count(const struct rmap_id_set *set);

/* Whether one of first ... last is in it. */
bool rmap_id_set_meets(const struct rmap_id_set *set, uint64_t first, uint64_t last);

/* inside[i]: 1 where id[i] is in it, else 0. Fastest where ids ascend. */
void rmap_id_set_mark(const struct rmap_id_set *set, const uint64_t *id, size_t n, uint8_t *inside);

#endif
