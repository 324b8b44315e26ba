/* SPDX-License-Identifier: MIT
 *
 * Numbers distinct sequences of 32-bit words in the order in which they are entered.
 */
#include "history/word_book.h"

#include <string.h>

#include "base/alloc.h"

enum { FIRST_SLOTS = 64 };

void rmap_word_book_fini(struct rmap_word_book *book)
{
    rmap_free(book->entry);
    rmap_free(book->word);
    rmap_free(book->slot);
    *book = (struct rmap_word_book){0};
}

void rmap_word_book_clear(struct rmap_word_book *book)
{
    book->n = book->n_word = 0;
    if (book->n_slot > 0)
        memset(book->slot, 0, book->n_slot * sizeof *book->slot);
}

/* The top bits of a hash are as good as any. */
static size_t home(const struct rmap_word_book *book, uint64_t hash)
{
    return (size_t)(hash >> 24) & (book->n_slot - 1);
}

uint32_t rmap_word_book_find(const struct rmap_word_book *book, uint64_t hash, const uint32_t *word,
                             size_t n)
{
    if (book->n == 0)
        return UINT32_MAX;
    for (size_t s = home(book, hash); book->slot[s] > 0; s = (s + 1) & (book->n_slot - 1)) {
        const struct rmap_word_entry *entry = &book->entry[book->slot[s] - 1];
        if (entry->hash == hash && entry->n == n &&
            memcmp(book->word + entry->first, word, n * sizeof *word) == 0)
            return book->slot[s] - 1;
    }
    return UINT32_MAX;
}

static void place(struct rmap_word_book *book, uint32_t number)
{
    size_t s = home(book, book->entry[number].hash);
    while (book->slot[s] > 0)
        s = (s + 1) & (book->n_slot - 1);
    book->slot[s] = number + 1;
}

static enum rmap_status widen(struct rmap_word_book *book, struct rmap_error *err)
{
    size_t n_slot = book->n_slot > 0 ? 2 * book->n_slot : FIRST_SLOTS;
    uint32_t *slot = rmap_alloc(n_slot, sizeof *slot);
    if (!slot)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu histories", n_slot);
    rmap_free(book->slot);
    book->slot = slot;
    book->n_slot = n_slot;
    for (size_t i = 0; i < book->n; i++)
        place(book, (uint32_t)i);
    return RMAP_OK;
}

enum rmap_status rmap_word_book_add(struct rmap_word_book *book, uint64_t hash,
                                    const uint32_t *word, size_t n, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    st = RMAP_RESERVE(book->entry, book->cap, book->n + 1, err);
    if (st != RMAP_OK)
        return st;
    st = RMAP_RESERVE(book->word, book->cap_word, book->n_word + n, err);
    if (st == RMAP_OK && 2 * (book->n + 1) > book->n_slot)
        st = widen(book, err);
    if (st != RMAP_OK)
        return st;
    memcpy(book->word + book->n_word, word, n * sizeof *word);
    book->entry[book->n] = (struct rmap_word_entry){hash, book->n_word, n};
    book->n_word += n;
    place(book, (uint32_t)book->n++);
    return RMAP_OK;
}

enum rmap_status rmap_word_book_enter(struct rmap_word_book *book, uint64_t hash,
                                      const uint32_t *word, size_t n, uint32_t *number_ret,
                                      struct rmap_error *err)
{
    *number_ret = rmap_word_book_find(book, hash, word, n);
    if (*number_ret != UINT32_MAX)
        return RMAP_OK;
    enum rmap_status st = rmap_word_book_add(book, hash, word, n, err);
    if (st == RMAP_OK)
        *number_ret = (uint32_t)(book->n - 1);
    return st;
}
