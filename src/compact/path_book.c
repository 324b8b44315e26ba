/* SPDX-License-Identifier: MIT
 *
 * Which paths stand in the dictionary of a piece. A path is entered when its hash is met for the
 * second time; hashes met once are kept in a table of fixed size, where a new one takes an old
 * one's place.
 */
#include <string.h>

#include "base/alloc.h"
#include "compact/paths.h"

#define SEEN_SLOTS ((size_t)1 << 16)
#define FIND_SLOTS ((size_t)2 * RMAP_PATH_MAX)

struct entry {
    uint64_t hash;
    size_t word; /* where its words begin */
};

struct rmap_path_book {
    uint64_t *seen;      /* [SEEN_SLOTS]; 0: free */
    uint32_t *slot;      /* [FIND_SLOTS], 1 + entry; 0: free */
    struct entry *entry; /* [n] */
    uint32_t *word;      /* of all entries */
    size_t n, n_row, n_word;
    size_t cap_entry, cap_word;
};

enum rmap_status rmap_path_book_create(struct rmap_path_book **book_ret, struct rmap_error *err)
{
    struct rmap_path_book *book = rmap_alloc(1, sizeof *book);
    if (book) {
        book->seen = rmap_alloc(SEEN_SLOTS, sizeof *book->seen);
        book->slot = rmap_alloc(FIND_SLOTS, sizeof *book->slot);
    }
    if (!book || !book->seen || !book->slot) {
        rmap_path_book_destroy(book);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a dictionary of paths");
    }
    *book_ret = book;
    return RMAP_OK;
}

void rmap_path_book_destroy(struct rmap_path_book *book)
{
    if (!book)
        return;
    rmap_free(book->seen);
    rmap_free(book->slot);
    rmap_free(book->entry);
    rmap_free(book->word);
    rmap_free(book);
}

static size_t rows_of(const uint32_t *word)
{
    return 1 + (size_t)word[RMAP_WORD_SEGMENTS] + word[RMAP_WORD_REGISTRATIONS];
}

static size_t slot_of(uint64_t hash)
{
    return (size_t)(hash >> 32) & (FIND_SLOTS - 1);
}

#if defined(__GNUC__)
#define soon(address) __builtin_prefetch(address)
#else
#define soon(address) ((void)(address))
#endif

void rmap_path_book_expect(const struct rmap_path_book *book, uint64_t hash)
{
    soon(&book->slot[slot_of(hash)]);
    soon(&book->seen[hash & (SEEN_SLOTS - 1)]);
}

enum rmap_status rmap_path_book_find(struct rmap_path_book *book, const uint32_t *word,
                                     uint64_t hash, uint32_t *reference_ret, bool *added_ret,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n_word = rmap_path_n_word(word), slot = slot_of(hash);
    *added_ret = false;
    *reference_ret = 0;
    for (; book->slot[slot]; slot = (slot + 1) & (FIND_SLOTS - 1)) {
        const struct entry *e = &book->entry[book->slot[slot] - 1];
        const uint32_t *known = book->word + e->word; /* equal heads: as many words */
        if (e->hash == hash && memcmp(known, word, RMAP_WORD_HEAD * sizeof *word) == 0 &&
            memcmp(known, word, n_word * sizeof *word) == 0) {
            *reference_ret = book->slot[slot];
            return RMAP_OK;
        }
    }
    uint64_t *seen = &book->seen[hash & (SEEN_SLOTS - 1)];
    if (*seen != hash || book->n == RMAP_PATH_MAX ||
        rows_of(word) > RMAP_PATH_ROW_MAX - book->n_row) {
        *seen = hash;
        return RMAP_OK;
    }
    RMAP_TRY(RMAP_RESERVE(book->entry, book->cap_entry, book->n + 1, err));
    RMAP_TRY(RMAP_RESERVE(book->word, book->cap_word, book->n_word + n_word, err));
    memcpy(book->word + book->n_word, word, n_word * sizeof *word);
    book->entry[book->n] = (struct entry){hash, book->n_word};
    book->n_word += n_word;
    book->n_row += rows_of(word);
    book->slot[slot] = *reference_ret = (uint32_t)++book->n;
    *added_ret = true;
out:
    return st;
}

/* rmap_reserve keeps one capacity per block; those of a table are grown alike. */
#define RESERVE_LIKE(field, own, n)                                                                \
    do {                                                                                           \
        size_t cap = own;                                                                          \
        RMAP_TRY(RMAP_RESERVE(rows->field, cap, n, err));                                          \
    } while (0)

enum rmap_status rmap_path_rows_reserve(struct rmap_path_rows *rows, size_t n, size_t n_segment,
                                        size_t n_registration, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    n += rows->n;
    n_segment += rows->n_segment;
    n_registration += rows->n_registration;
    RESERVE_LIKE(source, rows->cap, n);
    RESERVE_LIKE(stop, rows->cap, n);
    RESERVE_LIKE(start_object, rows->cap, n);
    RESERVE_LIKE(segment_count, rows->cap, n);
    RMAP_TRY(RMAP_RESERVE(rows->registration_count, rows->cap, n, err));
    RESERVE_LIKE(object, rows->cap_segment, n_segment);
    RMAP_TRY(RMAP_RESERVE(rows->event, rows->cap_segment, n_segment, err));
    RESERVE_LIKE(segment, rows->cap_registration, n_registration);
    RESERVE_LIKE(detector, rows->cap_registration, n_registration);
    RMAP_TRY(RMAP_RESERVE(rows->registered, rows->cap_registration, n_registration, err));
out:
    return st;
}

void rmap_path_rows_add(struct rmap_path_rows *rows, const uint32_t *word)
{
    size_t i = rows->n++, n = word[RMAP_WORD_SEGMENTS], m = word[RMAP_WORD_REGISTRATIONS];
    rows->source[i] = (int32_t)word[RMAP_WORD_SOURCE];
    rows->stop[i] = (uint8_t)word[RMAP_WORD_STOP];
    rows->start_object[i] = word[RMAP_WORD_START_OBJECT];
    rows->segment_count[i] = word[RMAP_WORD_SEGMENTS];
    rows->registration_count[i] = word[RMAP_WORD_REGISTRATIONS];
    word += RMAP_WORD_HEAD;
    if (n > 0) {
        memcpy(rows->object + rows->n_segment, word, n * sizeof *word);
        memcpy(rows->event + rows->n_segment, word + n, n * sizeof *word);
    }
    word += 2 * n;
    for (size_t k = 0; k < m; k++) {
        rows->segment[rows->n_registration + k] = word[k];
        rows->detector[rows->n_registration + k] = (int32_t)word[m + k];
        rows->registered[rows->n_registration + k] = (uint8_t)word[2 * m + k];
    }
    rows->n_segment += n;
    rows->n_registration += m;
}

void rmap_path_rows_fini(struct rmap_path_rows *rows)
{
    rmap_free(rows->source);
    rmap_free(rows->stop);
    rmap_free(rows->start_object);
    rmap_free(rows->segment_count);
    rmap_free(rows->registration_count);
    rmap_free(rows->object);
    rmap_free(rows->event);
    rmap_free(rows->segment);
    rmap_free(rows->detector);
    rmap_free(rows->registered);
    *rows = (struct rmap_path_rows){0};
}
