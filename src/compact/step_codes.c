/* SPDX-License-Identifier: MIT
 *
 * Classes of the segments of a portion's own paths as codes of a byte each.
 */
#include "compact/step_codes.h"

#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/byte_set.h"
#include "base/count.h"
#include "base/wide.h"
#include "compact/damaged.h"
#include "compact/streams.h"

void rmap_step_coder_fini(struct rmap_step_coder *coder)
{
    rmap_free(coder->n_met);
    rmap_free(coder->code);
    rmap_free(coder->met);
    rmap_free(coder->word);
    *coder = (struct rmap_step_coder){0};
}

static int by_number(const void *a, const void *b)
{
    const struct rmap_step_met *x = a, *y = b;
    if (x->n != y->n)
        return x->n < y->n ? 1 : -1;
    return (x->class > y->class) - (x->class < y->class);
}

/* Classes that are met, those met most often first. */
static enum rmap_status list(struct rmap_step_coder *coder, const uint32_t *class, size_t n,
                             size_t n_class, size_t *n_met_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n_met = 0;
    RMAP_TRY(RMAP_RESERVE(coder->n_met, coder->n_met_cap, n_class, err));
    RMAP_TRY(RMAP_RESERVE(coder->code, coder->code_cap, n_class, err));
    RMAP_TRY(RMAP_RESERVE(coder->met, coder->met_cap, n_class, err));
    memset(coder->n_met, 0, n_class * sizeof *coder->n_met);
    for (size_t i = 0; i < n; i++)
        coder->n_met[class[i]]++;
    for (size_t k = 0; k < n_class; k++)
        if (coder->n_met[k] > 0)
            coder->met[n_met++] = (struct rmap_step_met){coder->n_met[k], (uint32_t)k};
    qsort(coder->met, n_met, sizeof *coder->met, by_number);
    *n_met_ret = n_met;
out:
    return st;
}

static void write_words(struct rmap_step_coder *coder, const uint32_t *class, size_t n,
                        size_t n_code, size_t n_word)
{
    uint32_t *word = coder->word + n_code, *rare = word + (n + 3) / 4;
    size_t n_rare = 0;
    memset(coder->word, 0, n_word * sizeof *coder->word);
    for (size_t k = 0; k < n_code; k++)
        coder->word[k] = coder->met[k].class;
    for (size_t i = 0; i < n; i++) {
        const uint8_t code = coder->code[class[i]];
        word[i / 4] |= (uint32_t)code << 8 * (i % 4);
        if (code != RMAP_STEP_RARE)
            continue;
        rare[n_rare / 2] |= class[i] << 16 * (n_rare % 2);
        n_rare++;
    }
}

enum rmap_status rmap_step_codes_make(struct rmap_step_coder *coder, const uint32_t *class,
                                      size_t n, size_t n_class, size_t *n_word_ret,
                                      size_t *n_code_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n_met = 0, n_rare = 0;
    *n_code_ret = 0;
    if (n == 0 || n_class > RMAP_STEP_CLASS_MAX)
        goto out;
    RMAP_TRY(list(coder, class, n, n_class, &n_met, err));
    const size_t n_code = n_met < RMAP_STEP_RARE ? n_met : RMAP_STEP_RARE;
    for (size_t k = 0; k < n_met; k++) {
        coder->code[coder->met[k].class] = (uint8_t)(k < n_code ? k : RMAP_STEP_RARE);
        n_rare += k < n_code ? 0 : coder->met[k].n;
    }
    *n_word_ret = n_code + (n + 3) / 4 + (n_rare + 1) / 2;
    if (*n_word_ret >= n)
        goto out;
    RMAP_TRY(RMAP_RESERVE(coder->word, coder->word_cap, *n_word_ret, err));
    write_words(coder, class, n, n_code, *n_word_ret);
    *n_code_ret = n_code;
out:
    return st;
}

/* At most 2^32 rows of 2^32 segments: no sum is too large. */
static uint64_t count_segments(const struct rmap_rows *rows)
{
    const uint32_t *count = rows->data[RMAP_STREAM_OWN_segment_count];
    uint64_t n = 0;
    for (size_t k = 0; k < rows->n_row[RMAP_COMPACT_OWN]; k++)
        n += count[k];
    return n;
}

enum rmap_status rmap_step_codes_open(const struct rmap_rows *rows, size_t n_code,
                                      struct rmap_step_codes *codes, struct rmap_error *err)
{
    const uint32_t *word = rows->data[RMAP_STREAM_OWN_object];
    const size_t n_word = rows->n_row[RMAP_COMPACT_OWN_SEGMENT];
    *codes = (struct rmap_step_codes){0};
    if (n_code == 0)
        return RMAP_OK;
    const uint64_t n = count_segments(rows);
    if (n_code > n_word || n > 4 * (uint64_t)(n_word - n_code))
        return rmap_portion_damaged("it has fewer codes of steps than segments", err);
    *codes = (struct rmap_step_codes){.n_code = n_code, .n = (size_t)n};
    codes->n_rare_word = n_word - n_code - ((size_t)n + 3) / 4;
    if (!word)
        return RMAP_OK;
    codes->class_of = word;
    codes->code = (const uint8_t *)(word + n_code);
    codes->rare = word + (n_word - codes->n_rare_word);
    return RMAP_OK;
}

/* The k-th class of codes RMAP_STEP_RARE. Words are little-endian in memory, too. */
static inline uint32_t rare_class(const struct rmap_step_codes *codes, size_t k)
{
    uint16_t class;
    if (k / 2 >= codes->n_rare_word)
        return UINT32_MAX;
    memcpy(&class, (const char *)codes->rare + k * sizeof class, sizeof class);
    return class;
}

void rmap_step_codes_mark(const struct rmap_step_codes *codes, const uint8_t *pass, size_t n_class,
                          uint64_t *bits)
{
    enum { STRIP = 64 };
    static const uint8_t rarer = RMAP_STEP_RARE;
    uint8_t some[RMAP_STEP_RARE];
    uint64_t rare[STRIP];
    size_t n_some = 0, n_rare = 0;
    for (size_t i = 0; i < codes->n_code; i++)
        if (codes->class_of[i] < n_class && pass[codes->class_of[i]])
            some[n_some++] = (uint8_t)i;
    rmap_bytes_among(codes->code, codes->n, some, n_some, bits);
    for (size_t from = 0; from < codes->n; from += (size_t)64 * STRIP) {
        const size_t n = codes->n - from < 64 * STRIP ? codes->n - from : 64 * STRIP;
        rmap_bytes_among(codes->code + from, n, &rarer, 1, rare);
        for (size_t w = 0; w < rmap_bit_words(n); w++)
            for (uint64_t left = rare[w]; left; left &= left - 1) {
                const uint32_t class = rare_class(codes, n_rare++);
                const uint64_t passes = class < n_class && pass[class]; /* is anybody's guess */
                bits[from / 64 + w] |= (left & -left) & (0 - passes);
            }
    }
}

void rmap_step_codes_look_up(const struct rmap_step_codes *codes, const uint16_t *of_class,
                             size_t n_class, uint16_t *restrict out)
{
    const uint8_t *code = codes->code;
    const size_t n = codes->n;
    uint16_t of_code[256];
    size_t n_rare = 0;
    for (size_t k = 0; k < RMAP_COUNT(of_code); k++)
        of_code[k] = of_class[k < codes->n_code && codes->class_of[k] < n_class ? codes->class_of[k]
                                                                                : n_class];
    RMAP_UNROLL
    for (size_t i = 0; i < n; i++)
        out[i] = of_code[code[i]];
    for (const uint8_t *at = code, *end = at + n;
         (at = memchr(at, RMAP_STEP_RARE, (size_t)(end - at))); at++) {
        const uint32_t class = rare_class(codes, n_rare++);
        out[at - code] = of_class[class < n_class ? class : n_class];
    }
}

enum rmap_status rmap_step_codes_unpack(const struct rmap_rows *rows, size_t n_code,
                                        struct rmap_step_buffer *buffer, struct rmap_rows *out,
                                        struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_step_codes codes;
    uint32_t class_of[256];
    size_t n_rare = 0;
    *out = *rows;
    RMAP_TRY(rmap_step_codes_open(rows, n_code, &codes, err));
    if (codes.n_code == 0)
        goto out;
    out->n_row[RMAP_COMPACT_OWN_SEGMENT] = codes.n;
    out->data[RMAP_STREAM_OWN_event] = NULL;
    if (!buffer || !codes.code)
        goto out;
    RMAP_TRY(RMAP_RESERVE(buffer->class, buffer->cap, codes.n + 1, err));
    memset(class_of, 0xff, sizeof class_of);
    memcpy(class_of, codes.class_of, codes.n_code * sizeof *class_of);
    uint32_t *restrict class = buffer->class;
    const uint8_t *code = codes.code, *end = code + codes.n;
    RMAP_UNROLL
    for (size_t i = 0; i < codes.n; i++)
        class[i] = class_of[code[i]];
    for (const uint8_t *at = code; (at = memchr(at, RMAP_STEP_RARE, (size_t)(end - at))); at++)
        class[at - code] = rare_class(&codes, n_rare++);
    if ((n_rare + 1) / 2 != codes.n_rare_word)
        return rmap_portion_damaged("its codes of steps are not as many as its words", err);
    out->data[RMAP_STREAM_OWN_object] = buffer->class;
out:
    return st;
}
