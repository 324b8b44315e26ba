/* SPDX-License-Identifier: MIT
 *
 * Zemax's archives: heads, and LZW (T. A. Welch, Computer 17(6), 8 (1984)) with codes of 9 bits and
 * more, highest bit first, without a code that clears the table.
 */
#include "io/lensfile/lens_zar.h"

#include <string.h>
#include <strings.h>

#include "base/alloc.h"

enum {
    UNPACKED_MAX = 256 << 20,
    CODES_MAX = 1 << 24,
    OLD_HEAD = 0x14c,
    OLD_NAME = 0x20,
    NEW_HEAD = 0x288,
    NEW_NAME = 0x30,
    OLD = 0xea,
    NEW = 0xec
};

static uint64_t little_endian(const uint8_t *at, int n)
{
    uint64_t value = 0;
    for (int i = n; i-- > 0;)
        value = value << 8 | at[i];
    return value;
}

static bool ends_in(const char *name, const char *suffix)
{
    const size_t n = strlen(name), m = strlen(suffix);
    return n >= m && strcasecmp(name + n - m, suffix) == 0;
}

/* ---- LZW ---- */

/* Each code's text lies in what is already unpacked: [at, at + length). */
struct word {
    size_t at, length;
};

struct lzw {
    struct word *word; /* of codes from 256 */
    size_t n, cap;
    uint8_t *out;
    size_t nbytes, cap_out;
};

static enum rmap_status put(struct lzw *lzw, size_t code, size_t previous_at,
                            size_t previous_length, struct rmap_error *err)
{
    const bool is_known = code < 256 || code - 256 < lzw->n;
    const size_t length = code < 256 ? 1
                          : is_known ? lzw->word[code - 256].length
                                     : previous_length + 1;
    if (length > UNPACKED_MAX - lzw->nbytes)
        return rmap_error_set(err, RMAP_INPUT, "a file of it unpacks to more than 256 MiB");
    if (RMAP_RESERVE(lzw->out, lzw->cap_out, lzw->nbytes + length + 1, err) != RMAP_OK)
        return RMAP_SYSTEM;
    uint8_t *to = lzw->out + lzw->nbytes;
    if (code < 256) {
        *to = (uint8_t)code;
    } else if (is_known) {
        memcpy(to, lzw->out + lzw->word[code - 256].at, length);
    } else { /* the word before and its own first letter */
        memcpy(to, lzw->out + previous_at, previous_length);
        to[previous_length] = lzw->out[previous_at];
    }
    lzw->nbytes += length;
    return RMAP_OK;
}

static enum rmap_status unpack(const uint8_t *packed, size_t nbytes, struct lzw *lzw,
                               struct rmap_error *err)
{
    size_t bit = 0, previous_at = 0, previous_length = 0;
    unsigned width = 9;
    enum rmap_status st = RMAP_OK;
    while (st == RMAP_OK && bit + width <= 8 * nbytes) {
        size_t code = 0;
        for (unsigned i = 0; i < width; i++, bit++)
            code = code << 1 | (packed[bit / 8] >> (7 - bit % 8) & 1);
        if (code > 255 + lzw->n + (previous_length > 0))
            return rmap_error_set(err, RMAP_INPUT, "a file of it is damaged");
        const size_t at = lzw->nbytes;
        st = put(lzw, code, previous_at, previous_length, err);
        if (st == RMAP_OK && previous_length > 0 && lzw->n < CODES_MAX) {
            /* The word before and the first letter of this one stand in a row. */
            st = RMAP_RESERVE(lzw->word, lzw->cap, lzw->n + 1, err);
            if (st == RMAP_OK)
                lzw->word[lzw->n++] = (struct word){previous_at, previous_length + 1};
        }
        previous_at = at;
        previous_length = lzw->nbytes - at;
        while ((size_t)1 << width <= 256 + lzw->n)
            width++;
    }
    return st;
}

/* ---- heads ---- */

static void read_name(const uint8_t *head, bool is_new, char name[128])
{
    const uint8_t *at = head + (is_new ? NEW_NAME : OLD_NAME);
    const size_t step = is_new ? 2 : 1;
    size_t n = 0;
    for (; n + 1 < 128; n++, at += step) {
        const unsigned c = is_new ? (unsigned)little_endian(at, 2) : *at;
        if (c == 0)
            break;
        name[n] = c >= 0x20 && c < 0x7f ? (char)c : '?';
    }
    name[n] = 0;
}

static enum rmap_status take(const uint8_t *packed, size_t nbytes, bool is_packed,
                             struct rmap_zar_file *file, struct rmap_error *err)
{
    struct lzw lzw = {0};
    enum rmap_status st = RMAP_OK;
    if (is_packed)
        st = unpack(packed, nbytes, &lzw, err);
    else if (nbytes > UNPACKED_MAX)
        st = rmap_error_set(err, RMAP_INPUT, "a file of it has more than 256 MiB");
    if (st == RMAP_OK)
        st = RMAP_RESERVE(lzw.out, lzw.cap_out, (is_packed ? lzw.nbytes : nbytes) + 1, err);
    if (st == RMAP_OK && !is_packed) {
        memcpy(lzw.out, packed, nbytes);
        lzw.nbytes = nbytes;
    }
    rmap_free(lzw.word);
    if (st != RMAP_OK) {
        rmap_free(lzw.out);
        return st;
    }
    lzw.out[lzw.nbytes] = 0;
    file->bytes = lzw.out;
    file->nbytes = lzw.nbytes;
    return RMAP_OK;
}

enum rmap_status rmap_zar_next(const uint8_t *archive, size_t nbytes, size_t *at,
                               const char *suffix, struct rmap_zar_file *file, bool *found,
                               struct rmap_error *err)
{
    *found = false;
    *file = (struct rmap_zar_file){.nbytes = 0};
    while (*at < nbytes) {
        const uint8_t *head = archive + *at;
        const size_t left = nbytes - *at;
        const bool is_new = head[0] == NEW;
        const size_t n_head = is_new ? NEW_HEAD : OLD_HEAD;
        if (!is_new && head[0] != OLD)
            return rmap_error_set(err, RMAP_INPUT,
                                  "it is no archive of Zemax, or of a version that is not known: a "
                                  "head at byte %zu begins with 0x%02x",
                                  *at, head[0]);
        const uint64_t size = left < n_head
                                  ? UINT64_MAX
                                  : little_endian(head + (is_new ? 0x10 : 0x0c), is_new ? 8 : 4);
        if (left < n_head || size > left - n_head)
            return rmap_error_set(err, RMAP_INPUT, "it is cut off: a file at byte %zu is not whole",
                                  *at);
        read_name(head, is_new, file->name);
        *at += n_head + (size_t)size;
        const bool is_packed = ends_in(file->name, ".lzw");
        if (is_packed)
            file->name[strlen(file->name) - 4] = 0;
        if (suffix && !ends_in(file->name, suffix))
            continue;
        *found = true;
        return take(head + n_head, (size_t)size, is_packed, file, err);
    }
    return RMAP_OK;
}
