/* SPDX-License-Identifier: MIT
 *
 * Counts the legs of each ray whose class is wanted: codes become a bit per leg, and each ray
 * counts its own.
 */
#include <string.h>

#include "history/history_parts.h"

#if defined(__GNUC__) && defined(__x86_64__) && defined(__OPTIMIZE__)
#include <immintrin.h>
#define RMAP_HISTORY_AVX2 1
#endif

/* What is wanted, by local class. */
struct wanted {
    uint8_t common[256]; /* by code; 0 for those of rare classes */
    bool rare;           /* any of those without a code */
    uint64_t rows;       /* legs in all */
};

static void localise(const struct rmap_history_view *view, const uint8_t *wanted,
                     struct wanted *out)
{
    const uint32_t n_common = view->rows->shape.n_common;
    *out = (struct wanted){.rows = 0};
    for (size_t k = 0; k < view->n_local; k++) {
        bool is = wanted[view->local_class[k]] != 0;
        out->rows += is ? view->local_rows[k] : 0;
        if (k < n_common)
            out->common[k] = is;
        else
            out->rare |= is;
    }
}

/* ---- a bit per leg ---- */

static inline uint64_t pack_bits(const uint8_t *code, size_t n, const uint8_t member[256])
{
    uint64_t bits = 0;
    for (size_t i = 0; i < n; i++)
        bits |= (uint64_t)member[code[i]] << i;
    return bits;
}

static void mark_plain(const uint8_t *code, size_t first, size_t n, const uint8_t member[256],
                       uint64_t *mark)
{
    for (size_t i = first; i < n; i += 64)
        mark[i / 64] = pack_bits(code + i, n - i < 64 ? n - i : 64, member);
}

#ifdef RMAP_HISTORY_AVX2
/* A set of bytes as two tables by the low half of the byte: bit h of an entry stands for the high
 * half h (and h + 8). */
struct nibbles {
    __m256i low, high;
};

__attribute__((target("avx2"))) static struct nibbles nibbles_of(const uint8_t member[256])
{
    uint8_t table[2][32] = {{0}};
    for (unsigned c = 0; c < 256; c++)
        if (member[c])
            table[c >> 7][c & 15] |= (uint8_t)(1u << (c >> 4 & 7));
    memcpy(table[0] + 16, table[0], 16);
    memcpy(table[1] + 16, table[1], 16);
    return (struct nibbles){_mm256_loadu_si256((const void *)table[0]),
                            _mm256_loadu_si256((const void *)table[1])};
}

__attribute__((target("avx2"))) static inline uint64_t mark_32(const uint8_t *code,
                                                               const struct nibbles *set)
{
    const __m256i power = _mm256_set1_epi64x((long long)UINT64_C(0x8040201008040201));
    const __m256i half = _mm256_set1_epi8(15);
    __m256i c = _mm256_loadu_si256((const void *)code), low = _mm256_and_si256(c, half);
    __m256i high = _mm256_and_si256(_mm256_srli_epi16(c, 4), half);
    __m256i bit = _mm256_shuffle_epi8(power, high);
    __m256i row = _mm256_blendv_epi8(_mm256_shuffle_epi8(set->low, low),
                                     _mm256_shuffle_epi8(set->high, low), c);
    __m256i is = _mm256_cmpeq_epi8(_mm256_and_si256(row, bit), bit);
    return (uint32_t)_mm256_movemask_epi8(is);
}

__attribute__((target("avx2"))) static void mark_wide(const uint8_t *code, size_t n,
                                                      const uint8_t member[256], uint64_t *mark)
{
    const struct nibbles set = nibbles_of(member);
    size_t i = 0;
    for (; i + 64 <= n; i += 64)
        mark[i / 64] = mark_32(code + i, &set) | mark_32(code + i + 32, &set) << 32;
    mark_plain(code, i, n, member, mark);
}

static void mark_any(const uint8_t *code, size_t n, const uint8_t member[256], uint64_t *mark)
{
    if (__builtin_cpu_supports("avx2"))
        mark_wide(code, n, member, mark);
    else
        mark_plain(code, 0, n, member, mark);
}
#else
static void mark_any(const uint8_t *code, size_t n, const uint8_t member[256], uint64_t *mark)
{
    mark_plain(code, 0, n, member, mark);
}
#endif

void rmap_history_mark_codes(const struct rmap_history_view *view, const uint8_t member[256],
                             uint64_t *mark)
{
    mark_any(view->rows->code, view->n_row[RMAP_TABLE_SEGMENT], member, mark);
}

const uint64_t *rmap_history_rare_legs(const struct rmap_history_view *view)
{
    struct rmap_history_rows *rows = view->rows;
    size_t n_word = rmap_history_mark_words(view);
    uint64_t *rare = rows->mark + n_word;
    uint8_t member[256] = {0};
    uint32_t n = 0;
    if (rows->shape.n_rare == 0)
        return NULL;
    if (rows->is_ranked)
        return rare;
    for (uint32_t k = 0; k < rmap_history_n_page(rows->shape.n_local); k++)
        member[255 - k] = 1;
    rmap_history_mark_codes(view, member, rare);
    n_word = (view->n_row[RMAP_TABLE_SEGMENT] + 63) / 64;
    for (size_t w = 0; w < n_word; w++) {
        rows->rank[w] = n;
        n += (uint32_t)__builtin_popcountll(rare[w]);
    }
    rows->is_ranked = true;
    return rare;
}

/* Rare classes stand in their list in the order of the legs. Lists may be shorter than they should:
 * damage that a checksum hides. */
static void mark_rare(const struct rmap_history_view *view, const uint8_t *wanted, uint64_t *mark)
{
    const struct rmap_history_rows *rows = view->rows;
    const struct rmap_history_shape *shape = &rows->shape;
    const uint64_t *rare = rmap_history_rare_legs(view);
    uint32_t used = 0;
    for (size_t w = 0; rare && w * 64 < view->n_row[RMAP_TABLE_SEGMENT]; w++)
        for (uint64_t left = rare[w]; left != 0 && used < shape->n_rare; left &= left - 1) {
            uint8_t code = rows->code[w * 64 + (size_t)__builtin_ctzll(left)];
            uint32_t k = rmap_history_rare_class(shape, code, rows->rare[used++]);
            bool is = k < shape->n_local && wanted[view->local_class[k]] != 0;
            mark[w] |= is ? left & (0 - left) : 0;
        }
}

/* ---- counts from bits ---- */

#if defined(RMAP_HISTORY_AVX2) && !defined(__clang__)
#define COUNTING __attribute__((target_clones("arch=haswell", "default")))
#else
#define COUNTING
#endif

/* Eight bytes from any byte on hold 57 bits from any bit of it on. */
enum { READ_BITS = 57 };

static inline uint32_t count_some(const uint64_t *mark, uint64_t row, uint32_t n)
{
    uint64_t bits;
    memcpy(&bits, (const char *)mark + row / 8, sizeof bits);
    return (uint32_t)__builtin_popcountll(bits >> row % 8 & ((UINT64_C(1) << n) - 1));
}

COUNTING static void count_bits(const uint64_t *mark, const uint32_t *segment_count, size_t n_ray,
                                uint32_t *count)
{
    uint64_t row = 0;
    for (size_t i = 0; i < n_ray; i++) {
        uint32_t n = segment_count[i], sum = 0;
        for (; __builtin_expect(n > READ_BITS, 0); n -= READ_BITS, row += READ_BITS)
            sum += count_some(mark, row, READ_BITS);
        count[i] = sum + count_some(mark, row, n);
        row += n;
    }
}

/* What is wanted as bits in the view's marks. */
static void mark_wanted(const struct rmap_history_view *view, const uint8_t *wanted,
                        const struct wanted *local)
{
    uint64_t *mark = view->rows->mark;
    rmap_history_mark_codes(view, local->common, mark);
    if (local->rare)
        mark_rare(view, wanted, mark);
}

void rmap_history_count(const struct rmap_history_view *view, const uint8_t *wanted,
                        uint32_t *count)
{
    size_t n_ray = view->n_row[RMAP_TABLE_RAY];
    struct wanted local;
    localise(view, wanted, &local);
    if (local.rows == 0) {
        memset(count, 0, n_ray * sizeof *count);
    } else if (local.rows == view->n_row[RMAP_TABLE_SEGMENT]) {
        memcpy(count, view->segment_count, n_ray * sizeof *count);
    } else {
        mark_wanted(view, wanted, &local);
        count_bits(view->rows->mark, view->segment_count, n_ray, count);
    }
}

size_t rmap_history_keep(const struct rmap_history_view *view, const uint8_t *wanted,
                         struct rmap_history_place_of_ray *ray, size_t n)
{
    struct wanted local;
    size_t n_kept = 0;
    localise(view, wanted, &local);
    if (local.rows == 0 || n == 0)
        return 0;
    mark_wanted(view, wanted, &local);
    for (size_t i = 0; i < n; i++) {
        const struct rmap_history_place_of_ray it = ray[i];
        uint32_t left = view->segment_count[it.ray], sum = 0;
        size_t row = it.leg;
        for (; __builtin_expect(left > READ_BITS, 0); left -= READ_BITS, row += READ_BITS)
            sum += count_some(view->rows->mark, row, READ_BITS);
        ray[n_kept] = it;
        n_kept += sum + count_some(view->rows->mark, row, left) > 0;
    }
    return n_kept;
}

void rmap_history_count_hits(const struct rmap_history_view *view, const uint8_t *wanted,
                             uint32_t *count)
{
    const struct rmap_history_rows *rows = view->rows;
    size_t n_ray = view->n_row[RMAP_TABLE_RAY], at = 0;
    unsigned nbytes = rows->shape.hit_nbytes;
    if (!view->registration_count) {
        memset(count, 0, n_ray * sizeof *count);
        return;
    }
    if (nbytes == 0) {
        uint32_t all = wanted[rmap_history_number(rows->hit, 0, 0)] ? UINT32_MAX : 0;
        for (size_t i = 0; i < n_ray; i++)
            count[i] = view->registration_count[i] & all;
        return;
    }
    for (size_t i = 0; i < n_ray; i++) {
        count[i] = 0;
        for (size_t end = at + view->registration_count[i]; at < end; at++)
            count[i] += wanted[rmap_history_number(rows->hit, nbytes, at)] != 0;
    }
}
