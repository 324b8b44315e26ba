/* SPDX-License-Identifier: MIT
 *
 * The dictionary of paths of a piece being written.
 */
#include "compact/path_book.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"

/* Which paths stand in the dictionary of a piece. A path is entered when its hash is met for the
 * second time; hashes met once are kept in a table of fixed size, where a new one takes an old
 * one's place. */

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
    struct rmap_step_classes classes;
    struct rmap_path_sum *sum; /* [RMAP_PATH_MAX + 1] by reference; 0: of their own */
    bool is_plain;             /* all portions so far */
};

enum rmap_status rmap_path_book_create(struct rmap_path_book **book_ret, struct rmap_error *err)
{
    struct rmap_path_book *book = rmap_alloc(1, sizeof *book);
    if (book) {
        book->seen = rmap_alloc(SEEN_SLOTS, sizeof *book->seen);
        book->slot = rmap_alloc(FIND_SLOTS, sizeof *book->slot);
        book->sum = rmap_alloc(RMAP_PATH_MAX + 1, sizeof *book->sum);
        book->is_plain = true;
    }
    if (!book || !book->seen || !book->slot || !book->sum) {
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
    rmap_free(book->sum);
    rmap_step_classes_fini(&book->classes);
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

struct rmap_step_classes *rmap_path_book_classes(struct rmap_path_book *book)
{
    return &book->classes;
}

/* The float next to x, towards `to`, unless x is one. */
static float round_towards(double x, float to)
{
    const float near = (float)x;
    const bool beyond = to > 0.0f ? (double)near >= x : (double)near <= x;
    return beyond ? near : nextafterf(near, to);
}

static void widen(float bound[2], double x, bool is_first)
{
    if (is_first || x < (double)bound[0])
        bound[0] = round_towards(x, -HUGE_VALF);
    if (is_first || x > (double)bound[1])
        bound[1] = round_towards(x, HUGE_VALF);
    if (isnan(x))
        bound[0] = bound[1] = NAN; /* and so they stay */
}

void rmap_path_book_add(struct rmap_path_book *book, const uint32_t *path,
                        const double (*length)[2], size_t n_ray, bool plain)
{
    book->is_plain &= plain;
    for (size_t i = 0; i < n_ray; i++) {
        struct rmap_path_sum *sum = &book->sum[path[i]];
        const bool is_first = sum->rays++ == 0;
        widen(sum->path_length, length[i][0], is_first);
        widen(sum->optical_path, length[i][1], is_first);
    }
}

const struct rmap_path_sum *rmap_path_book_sums(struct rmap_path_book *book)
{
    enum { FEW = 16 };
    if (!book->is_plain)
        return NULL;
    for (size_t i = 1; i <= book->n; i++)
        for (int k = 0; k < 2 && book->sum[i].rays < FEW; k++)
            book->sum[i].path_length[k] = book->sum[i].optical_path[k] = NAN;
    return book->sum + 1;
}

static bool has_room(const struct rmap_path_book *book, const uint32_t *word)
{
    return book->n < RMAP_PATH_MAX && rows_of(word) <= RMAP_PATH_ROW_MAX - book->n_row;
}

/* There is room. */
static enum rmap_status enter(struct rmap_path_book *book, const uint32_t *word, uint64_t hash,
                              uint32_t *reference_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n_word = rmap_path_n_word(word);
    size_t slot = slot_of(hash);
    while (book->slot[slot])
        slot = (slot + 1) & (FIND_SLOTS - 1);
    RMAP_TRY(RMAP_RESERVE(book->entry, book->cap_entry, book->n + 1, err));
    RMAP_TRY(RMAP_RESERVE(book->word, book->cap_word, book->n_word + n_word, err));
    memcpy(book->word + book->n_word, word, n_word * sizeof *word);
    book->entry[book->n] = (struct entry){hash, book->n_word};
    book->n_word += n_word;
    book->n_row += rows_of(word);
    book->slot[slot] = *reference_ret = (uint32_t)++book->n;
out:
    return st;
}

enum rmap_status rmap_path_book_find(struct rmap_path_book *book, const uint32_t *word,
                                     uint64_t hash, uint32_t *reference_ret, bool *added_ret,
                                     struct rmap_error *err)
{
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
    if (*seen != hash || !has_room(book, word)) {
        *seen = hash;
        return RMAP_OK;
    }
    const enum rmap_status st = enter(book, word, hash, reference_ret, err);
    *added_ret = st == RMAP_OK;
    return st;
}

enum rmap_status rmap_path_book_enter(struct rmap_path_book *book, const uint32_t *word,
                                      uint64_t hash, uint32_t *reference_ret,
                                      struct rmap_error *err)
{
    *reference_ret = 0;
    return has_room(book, word) && book->n < RMAP_PATH_MAX / 2
               ? enter(book, word, hash, reference_ret, err)
               : RMAP_OK;
}
