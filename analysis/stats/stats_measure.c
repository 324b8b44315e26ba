/* SPDX-License-Identifier: MIT */
#include "analysis/stats/stats_measure.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "base/intrinsics.h"
#include "base/wide.h"

enum { LANES = 8, VECTOR = 4 };

typedef double vector __attribute__((vector_size(VECTOR * sizeof(double))));
typedef int64_t mask __attribute__((vector_size(VECTOR * sizeof(double))));

/* What there is to know of numbers, each lane of every LANES-th of them. */
struct lanes {
    double low[LANES], high[LANES], sum[LANES], squared[LANES];
};

/* The same of VECTOR lanes. */
struct vectors {
    vector low, high, sum, squared;
};

static inline void take_lanes(struct vectors *its, const struct lanes *lanes, size_t lane)
{
    memcpy(&its->low, lanes->low + lane, sizeof its->low);
    memcpy(&its->high, lanes->high + lane, sizeof its->high);
    memcpy(&its->sum, lanes->sum + lane, sizeof its->sum);
    memcpy(&its->squared, lanes->squared + lane, sizeof its->squared);
}

static inline void give_lanes(const struct vectors *its, struct lanes *lanes, size_t lane)
{
    memcpy(lanes->low + lane, &its->low, sizeof its->low);
    memcpy(lanes->high + lane, &its->high, sizeof its->high);
    memcpy(lanes->sum + lane, &its->sum, sizeof its->sum);
    memcpy(lanes->squared + lane, &its->squared, sizeof its->squared);
}

static inline void look_at_vector(struct vectors *its, const double *value)
{
    vector v;
    memcpy(&v, value, sizeof v);
    const mask less = v<its->low, more = v> its->high;
    its->low = (vector)(((mask)v & less) | ((mask)its->low & ~less));
    its->high = (vector)(((mask)v & more) | ((mask)its->high & ~more));
    its->sum += v;
    its->squared += v * v;
}

/* n: a multiple of LANES. */
static void measure_narrow(const double *value, size_t n, struct lanes *lanes)
{
    struct vectors first, second;
    take_lanes(&first, lanes, 0);
    take_lanes(&second, lanes, VECTOR);
    for (size_t k = 0; k < n; k += LANES) {
        look_at_vector(&first, value + k);
        look_at_vector(&second, value + k + VECTOR);
    }
    give_lanes(&first, lanes, 0);
    give_lanes(&second, lanes, VECTOR);
}

#ifdef RMAP_INTRINSICS
/* The least and greatest in one instruction each, which leaves what is there for what is none. */
__attribute__((target("avx2"))) static void measure_wide(const double *value, size_t n,
                                                         struct lanes *lanes)
{
    enum { HALVES = LANES / VECTOR };
    __m256d low[HALVES], high[HALVES], sum[HALVES], squared[HALVES];
    for (size_t h = 0; h < HALVES; h++) {
        low[h] = _mm256_loadu_pd(lanes->low + h * VECTOR);
        high[h] = _mm256_loadu_pd(lanes->high + h * VECTOR);
        sum[h] = squared[h] = _mm256_setzero_pd();
    }
    for (size_t k = 0; k < n; k += LANES)
        for (size_t h = 0; h < HALVES; h++) {
            const __m256d v = _mm256_loadu_pd(value + k + h * VECTOR);
            low[h] = _mm256_min_pd(v, low[h]);
            high[h] = _mm256_max_pd(v, high[h]);
            sum[h] = _mm256_add_pd(sum[h], v);
            squared[h] = _mm256_add_pd(squared[h], _mm256_mul_pd(v, v));
        }
    for (size_t h = 0; h < HALVES; h++) {
        _mm256_storeu_pd(lanes->low + h * VECTOR, low[h]);
        _mm256_storeu_pd(lanes->high + h * VECTOR, high[h]);
        _mm256_storeu_pd(lanes->sum + h * VECTOR, sum[h]);
        _mm256_storeu_pd(lanes->squared + h * VECTOR, squared[h]);
    }
}

static bool is_wide(void)
{
    return __builtin_cpu_supports("avx2");
}
#else
#define measure_wide(value, n, lanes) measure_narrow(value, n, lanes)
#define is_wide()                     false
#endif

struct rmap_stats_measured rmap_stats_measure(const double *value, size_t n)
{
    const double infinity = (double)INFINITY;
    const size_t n_wide = n / LANES * LANES;
    struct rmap_stats_measured all = {.low = infinity, .high = -infinity};
    struct lanes lanes = {.sum = {0.0}};
    for (size_t lane = 0; lane < LANES; lane++) {
        lanes.low[lane] = infinity;
        lanes.high[lane] = -infinity;
    }
    if (n_wide > 0 && is_wide())
        measure_wide(value, n_wide, &lanes);
    else if (n_wide > 0)
        measure_narrow(value, n_wide, &lanes);
    for (size_t k = n_wide; k < n; k++) {
        const double v = value[k];
        all.low = v < all.low ? v : all.low;
        all.high = v > all.high ? v : all.high;
        lanes.sum[0] += v;
        lanes.squared[0] += v * v;
    }
    for (size_t lane = 0; lane < LANES; lane++) {
        all.low = lanes.low[lane] < all.low ? lanes.low[lane] : all.low;
        all.high = lanes.high[lane] > all.high ? lanes.high[lane] : all.high;
        all.sum += lanes.sum[lane];
        all.squared += lanes.squared[lane];
    }
    return all;
}

/* By their bits: positive numbers stand in the order of theirs, below all others. */
RMAP_WIDE double rmap_stats_least_positive(const double *value, size_t n)
{
    uint64_t least = UINT64_C(0x7ff0000000000000) - 1; /* of infinity */
    for (size_t k = 0; k < n; k++) {
        uint64_t bits;
        memcpy(&bits, value + k, sizeof bits);
        least = bits - 1 < least ? bits - 1 : least; /* 0 is the greatest of all */
    }
    const uint64_t bits = least + 1;
    double number;
    memcpy(&number, &bits, sizeof number);
    return number;
}
