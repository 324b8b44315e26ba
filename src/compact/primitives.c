/* SPDX-License-Identifier: MIT */
#include "compact/primitives.h"

#include "base/intrinsics.h"

/* Legs [first, n), whose next triangle is k; the next one after them. */
static size_t place(const struct rmap_compact_model *model, const int32_t *object, size_t first,
                    size_t n, const uint32_t *triangle, size_t n_triangle, size_t k,
                    int32_t *primitive)
{
    for (size_t i = first; i < n && n_triangle == 0; i++)
        primitive[i] = object[i] < 0 ? -1 : 0;
    for (size_t i = first; i < n && n_triangle > 0; i++) {
        /* no branch: whether it is a mesh is anybody's guess */
        size_t its = (uint32_t)object[i];
        uint32_t listed = model->listed[its < model->n_object ? its : model->n_object];
        uint32_t plain = object[i] < 0 ? UINT32_MAX : 0;
        uint32_t next = triangle[k < n_triangle ? k : 0];
        primitive[i] = (int32_t)(plain ^ ((plain ^ next) & listed));
        k += listed & 1;
    }
    return k;
}

#ifdef RMAP_INTRINSICS

/* For each set of lanes, how many of it come before each lane. */
#define BEFORE(m, k)                                                                               \
    (((m)&1 & ((k) > 0)) + ((m) >> 1 & 1 & ((k) > 1)) + ((m) >> 2 & 1 & ((k) > 2)) +               \
     ((m) >> 3 & 1 & ((k) > 3)) + ((m) >> 4 & 1 & ((k) > 4)) + ((m) >> 5 & 1 & ((k) > 5)) +        \
     ((m) >> 6 & 1 & ((k) > 6)))
#define SET(m)                                                                                     \
    {                                                                                              \
        BEFORE(m, 0), BEFORE(m, 1), BEFORE(m, 2), BEFORE(m, 3), BEFORE(m, 4), BEFORE(m, 5),        \
            BEFORE(m, 6), BEFORE(m, 7)                                                             \
    }
#define SETS_4(m)  SET(m), SET((m) + 1), SET((m) + 2), SET((m) + 3)
#define SETS_16(m) SETS_4(m), SETS_4((m) + 4), SETS_4((m) + 8), SETS_4((m) + 12)
#define SETS_64(m) SETS_16(m), SETS_16((m) + 16), SETS_16((m) + 32), SETS_16((m) + 48)
static const uint8_t before[256][8] = {SETS_64(0), SETS_64(64), SETS_64(128), SETS_64(192)};

/* Eight legs at once, as long as there are eight triangles. *k: the next one. Legs done. */
__attribute__((target("avx2,popcnt"))) static size_t
place_8(const struct rmap_compact_model *model, const int32_t *object, size_t n,
        const uint32_t *triangle, size_t n_triangle, size_t *k, int32_t *primitive)
{
    const __m256i nobody = _mm256_set1_epi32((int)model->n_object);
    size_t i = 0, next = 0;
    for (; i + 8 <= n && next + 8 <= n_triangle; i += 8) {
        __m256i its = _mm256_loadu_si256((const void *)(object + i));
        __m256i listed =
            _mm256_i32gather_epi32((const int *)model->listed, _mm256_min_epu32(its, nobody), 4);
        unsigned set = (unsigned)_mm256_movemask_ps(_mm256_castsi256_ps(listed));
        __m256i from = _mm256_cvtepu8_epi32(_mm_loadl_epi64((const void *)before[set]));
        __m256i eight = _mm256_loadu_si256((const void *)(triangle + next));
        __m256i spread = _mm256_permutevar8x32_epi32(eight, from);
        __m256i plain = _mm256_srai_epi32(its, 31);
        _mm256_storeu_si256((void *)(primitive + i), _mm256_blendv_epi8(plain, spread, listed));
        next += (size_t)__builtin_popcount(set);
    }
    *k = next;
    return i;
}

static size_t place_fast(const struct rmap_compact_model *model, const int32_t *object, size_t n,
                         const uint32_t *triangle, size_t n_triangle, size_t *k, int32_t *primitive)
{
    if (model->n_object > INT32_MAX || !__builtin_cpu_supports("avx2"))
        return 0;
    return place_8(model, object, n, triangle, n_triangle, k, primitive);
}
#else
static size_t place_fast(const struct rmap_compact_model *model, const int32_t *object, size_t n,
                         const uint32_t *triangle, size_t n_triangle, size_t *k, int32_t *primitive)
{
    (void)model;
    (void)object;
    (void)n;
    (void)triangle;
    (void)n_triangle;
    (void)k;
    (void)primitive;
    return 0;
}
#endif

size_t rmap_primitives_place(const struct rmap_compact_model *model, const int32_t *object,
                             size_t n, const uint32_t *triangle, size_t n_triangle,
                             int32_t *primitive)
{
    size_t k = 0;
    size_t done = place_fast(model, object, n, triangle, n_triangle, &k, primitive);
    return place(model, object, done, n, triangle, n_triangle, k, primitive);
}
