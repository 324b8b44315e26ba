/* SPDX-License-Identifier: MIT
 *
 * Numbers distinct sequences of 32-bit words in the order in which they are entered.
 */
#ifndef RMAP_WORD_BOOK_H
#define RMAP_WORD_BOOK_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

struct rmap_word_entry {
    uint64_t hash;
    size_t first, n; /* of the book's words */
};

/* Zeroed: empty. Entries and words are for reading. */
struct rmap_word_book {
    struct rmap_word_entry *entry; /* [n] */
    uint32_t *word;                /* [n_word] */
    size_t n, n_word;
    size_t cap, cap_word;
    uint32_t *slot; /* [n_slot] number + 1, at or behind the place of the hash; 0: free */
    size_t n_slot;  /* power of 2, or 0 */
};

void rmap_word_book_fini(struct rmap_word_book *book);

/* Empties it and keeps its memory. */
void rmap_word_book_clear(struct rmap_word_book *book);

/* Number of the sequence, or UINT32_MAX. hash: of the words, always by the same function. */
uint32_t rmap_word_book_find(const struct rmap_word_book *book, uint64_t hash, const uint32_t *word,
                             size_t n);

/* Enters a sequence that is not there; its number is that of entries before it. */
enum rmap_status rmap_word_book_add(struct rmap_word_book *book, uint64_t hash,
                                    const uint32_t *word, size_t n,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* Finds it, or enters it. */
enum rmap_status rmap_word_book_enter(struct rmap_word_book *book, uint64_t hash,
                                      const uint32_t *word, size_t n, uint32_t *number_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
