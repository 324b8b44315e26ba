/* SPDX-License-Identifier: MIT */
#include "analysis/paths/step_letters.h"

#include "base/intrinsics.h"

enum { EVENT_BITS = 13, EVENT_CODES = 1 << EVENT_BITS, LETTER_BITS = 4 };

static uint8_t least_of(const struct rmap_step_letters *letters, uint32_t events)
{
    uint8_t least = UINT8_MAX;
    for (int k = 0; k < 4; k++) {
        const uint8_t its = letters->least[k][events >> 4 * k & 15];
        least = its < least ? its : least;
    }
    return least;
}

#ifdef RMAP_INTRINSICS
static bool is_wide(void)
{
    return __builtin_cpu_supports("avx2");
}

#define AVX2 __attribute__((target("avx2"))) static inline

/* 16 numbers of 32 bits as 16, in the order that packing makes: that of `store`. */
AVX2 __m256i load_objects(const int32_t *object)
{
    return _mm256_packs_epi32(_mm256_loadu_si256((const void *)object),
                              _mm256_loadu_si256((const void *)(object + 8)));
}

AVX2 __m256i load_events(const uint32_t *event)
{
    const __m256i codes = _mm256_set1_epi32(EVENT_CODES - 1);
    return _mm256_packus_epi32(
        _mm256_and_si256(_mm256_loadu_si256((const void *)event), codes),
        _mm256_and_si256(_mm256_loadu_si256((const void *)(event + 8)), codes));
}

AVX2 __m256i table_of(const uint8_t table[16])
{
    return _mm256_broadcastsi128_si256(_mm_loadu_si128((const void *)table));
}

/* Each half of a byte in the table for it: `even` for lower bytes, `odd` for upper ones. */
AVX2 __m256i look_up(__m256i even, __m256i odd, __m256i nibbles)
{
    const __m256i upper = _mm256_set1_epi16((short)0xff00);
    return _mm256_blendv_epi8(_mm256_shuffle_epi8(even, nibbles), _mm256_shuffle_epi8(odd, nibbles),
                              upper);
}

__attribute__((target("avx2"))) static size_t steps_wide(const struct rmap_step_letters *letters,
                                                         const int32_t *object,
                                                         const uint32_t *event, size_t n,
                                                         uint16_t *step, bool *inside_ret)
{
    const __m256i half = _mm256_set1_epi8(15), lower = _mm256_set1_epi16(15);
    const __m256i one = _mm256_set1_epi16(1);
    const __m256i least[4] = {table_of(letters->least[0]), table_of(letters->least[1]),
                              table_of(letters->least[2]), table_of(letters->least[3])};
    const __m256i inside = table_of(letters->is_inside);
    __m256i seen = _mm256_setzero_si256();
    size_t i = 0;
    for (; i + 16 <= n; i += 16) {
        const __m256i at = load_objects(object + i), events = load_events(event + i);
        const __m256i low = _mm256_and_si256(events, half);
        const __m256i high = _mm256_and_si256(_mm256_srli_epi16(events, 4), half);
        const __m256i both =
            _mm256_min_epu8(look_up(least[0], least[2], low), look_up(least[1], least[3], high));
        const __m256i letter =
            _mm256_and_si256(_mm256_min_epu8(both, _mm256_srli_epi16(both, 8)), lower);
        const __m256i place = _mm256_slli_epi16(_mm256_add_epi16(at, one), LETTER_BITS);
        seen = _mm256_or_si256(
            seen, _mm256_and_si256(_mm256_srai_epi16(at, 15), _mm256_shuffle_epi8(inside, letter)));
        _mm256_storeu_si256((void *)(step + i),
                            _mm256_permute4x64_epi64(_mm256_or_si256(place, letter), 0xd8));
    }
    *inside_ret = !_mm256_testz_si256(seen, seen);
    return i;
}
#else
static bool is_wide(void)
{
    return false;
}

static size_t steps_wide(const struct rmap_step_letters *letters, const int32_t *object,
                         const uint32_t *event, size_t n, uint16_t *step, bool *inside_ret)
{
    (void)letters;
    (void)object;
    (void)event;
    (void)n;
    (void)step;
    (void)inside_ret;
    return 0;
}
#endif

void rmap_step_letters_init(struct rmap_step_letters *letters, const uint8_t *letter,
                            uint32_t inside)
{
    for (uint32_t k = 0; k < 4; k++)
        for (uint32_t bits = 0; bits < 16; bits++)
            letters->least[k][bits] = letter[bits << 4 * k & (EVENT_CODES - 1)];
    for (uint32_t k = 0; k < 16; k++)
        letters->is_inside[k] = inside >> k & 1 ? UINT8_MAX : 0;
    letters->is_usable = is_wide();
    for (uint32_t events = 0; events < EVENT_CODES; events++)
        letters->is_usable &= least_of(letters, events) == letter[events];
}

size_t rmap_step_letters_steps(const struct rmap_step_letters *letters, const int32_t *object,
                               const uint32_t *event, size_t n, uint16_t *step, bool *inside_ret)
{
    *inside_ret = false;
    return letters->is_usable ? steps_wide(letters, object, event, n, step, inside_ret) : 0;
}
