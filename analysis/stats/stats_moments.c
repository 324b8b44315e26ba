/* SPDX-License-Identifier: MIT */
#include "analysis/stats/stats_moments.h"

#include <string.h>

#include "base/intrinsics.h"
#include "base/wide.h"

/* Lanes keep sums apart that a vector adds at once; how many is part of the result. */
enum { LANES = 16 };

RMAP_WIDE static void centred(const double *restrict value, size_t n, double centre,
                              double per_scale, double *restrict u)
{
    for (size_t k = 0; k < n; k++)
        u[k] = (value[k] - centre) * per_scale;
}

enum { VECTOR = 4, POWERS = RMAP_MOMENT_POWERS - 1 };
typedef double vector __attribute__((vector_size(VECTOR * sizeof(double))));

/* Readings whose powers are summed, and what goes on beside, for which sums leave the processor
 * time. */
struct batch {
    const double *value; /* [n] */
    size_t n;            /* a multiple of LANES */
    const double *tail;  /* [LANES] more of them; NULL: none */
    double centre, per_scale;
    const uint16_t *place; /* [n] */
    uint32_t *count;       /* of each place */
    const double *next;    /* so many will be read next */
};

/* Sums of u, u^2, ..., each of every LANES-th of the readings. */
struct lanes {
    double sum[POWERS][LANES];
};

RMAP_COPIED void add_powers_4(const struct batch *batch, const double *value, vector sum[POWERS])
{
    vector its, power;
    memcpy(&its, value, sizeof its);
    power = its = (its - batch->centre) * batch->per_scale;
    sum[0] += power;
    RMAP_UNROLL for (size_t k = 1; k < POWERS; k++)
    {
        power *= its;
        sum[k] += power;
    }
}

/* VECTOR of the lanes, from `lane` on; a part of the places. */
RMAP_WIDE static void sum_some(const struct batch *batch, size_t lane, struct lanes *lanes)
{
    const size_t first = lane / VECTOR * (batch->n / LANES) * VECTOR;
    const uint16_t *place = batch->place + first;
    const double *next = batch->next + first;
    uint32_t *count = batch->count;
    vector sum[POWERS];
    RMAP_UNROLL for (size_t k = 0; k < POWERS; k++) sum[k] = (vector){0.0};
    for (size_t i = lane; i < batch->n; i += LANES, place += VECTOR, next += VECTOR) {
        add_powers_4(batch, batch->value + i, sum);
        RMAP_UNROLL for (size_t k = 0; k < VECTOR; k++) count[place[k]]++;
        __builtin_prefetch(next);
    }
    if (batch->tail)
        add_powers_4(batch, batch->tail + lane, sum);
    RMAP_UNROLL for (size_t k = 0; k < POWERS; k++)
        memcpy(lanes->sum[k] + lane, &sum[k], sizeof sum[k]);
}

#ifdef RMAP_INTRINSICS
enum { VECTOR_512 = 8, HALVES = LANES / VECTOR_512 };
typedef double vector_512 __attribute__((vector_size(VECTOR_512 * sizeof(double))));

__attribute__((target("avx512f"), always_inline)) static inline void
add_powers_16(const struct batch *batch, const double *value, vector_512 sum[HALVES][POWERS])
{
    vector_512 its[HALVES], power[HALVES];
    RMAP_UNROLL for (size_t h = 0; h < HALVES; h++)
    {
        memcpy(&its[h], value + h * VECTOR_512, sizeof its[h]);
        power[h] = its[h] = (its[h] - batch->centre) * batch->per_scale;
        sum[h][0] += power[h];
    }
    RMAP_UNROLL for (size_t k = 1; k < POWERS; k++)
    {
        RMAP_UNROLL for (size_t h = 0; h < HALVES; h++)
        {
            power[h] *= its[h];
            sum[h][k] += power[h];
        }
    }
}

/* All lanes: there are registers for so many sums, and values are read once. */
__attribute__((target("avx512f"))) static void sum_all(const struct batch *batch,
                                                       struct lanes *lanes)
{
    const uint16_t *place = batch->place;
    const double *next = batch->next;
    uint32_t *count = batch->count;
    vector_512 sum[HALVES][POWERS];
    RMAP_UNROLL for (size_t k = 0; k < POWERS; k++) sum[0][k] = sum[1][k] = (vector_512){0.0};
    for (size_t i = 0; i < batch->n; i += LANES) {
        add_powers_16(batch, batch->value + i, sum);
        RMAP_UNROLL for (size_t k = 0; k < LANES; k++) count[place[i + k]]++;
        __builtin_prefetch(next + i);
        __builtin_prefetch(next + i + VECTOR_512);
    }
    if (batch->tail)
        add_powers_16(batch, batch->tail, sum);
    RMAP_UNROLL for (size_t k = 0; k < POWERS; k++)
    {
        memcpy(lanes->sum[k], &sum[0][k], sizeof sum[0][k]);
        memcpy(lanes->sum[k] + VECTOR_512, &sum[1][k], sizeof sum[1][k]);
    }
}

static bool is_512(void)
{
    return __builtin_cpu_supports("avx512f");
}
#else
#define sum_all(batch, lanes) ((void)0)
#define is_512()              false
#endif

static void sum_powers(const struct batch *batch, struct lanes *lanes)
{
    if (is_512()) {
        sum_all(batch, lanes);
        return;
    }
    for (size_t lane = 0; lane < LANES; lane += VECTOR)
        sum_some(batch, lane, lanes);
}

/* Over the lanes: by halves. */
static double sum_lanes(const double lane[LANES])
{
    double four[VECTOR];
    for (size_t k = 0; k < VECTOR; k++)
        four[k] = (lane[k] + lane[k + 2 * VECTOR]) + (lane[k + VECTOR] + lane[k + 3 * VECTOR]);
    return (four[0] + four[2]) + (four[1] + four[3]);
}

/* For sums beside which nothing is counted. */
static const uint16_t nowhere[RMAP_MOMENT_BATCH] = {0};

/* A batch of n readings; up to a multiple of LANES such follow that u is 0. */
static void add_batch(struct rmap_stats_moments *moments, const struct rmap_moment_ones *ones,
                      size_t n)
{
    struct lanes lanes;
    double tail[LANES];
    uint32_t ignored = 0;
    const size_t n_wide = n / LANES * LANES;
    for (size_t k = 0; k < LANES && n_wide < n; k++)
        tail[k] = n_wide + k < n ? ones->value[n_wide + k] : ones->centre;
    const struct batch batch = {.value = ones->value,
                                .n = n_wide,
                                .tail = n_wide < n ? tail : NULL,
                                .centre = ones->centre,
                                .per_scale = ones->per_scale,
                                .place = ones->place ? ones->place : nowhere,
                                .count = ones->place ? ones->count : &ignored,
                                .next = ones->next ? ones->next : ones->value};
    sum_powers(&batch, &lanes);
    for (size_t k = n_wide; ones->place && k < n; k++)
        ones->count[ones->place[k]]++;
    rmap_exact_sum_add(&moments->power[0], (double)n);
    for (size_t k = 0; k < POWERS; k++)
        rmap_exact_sum_add(&moments->power[k + 1], sum_lanes(lanes.sum[k]));
}

static void flush_ones(struct rmap_stats_moments *moments)
{
    const struct rmap_moment_ones ones = {.value = moments->waiting, .per_scale = 1.0};
    add_batch(moments, &ones, moments->n_waiting);
    moments->n_waiting = 0;
}

/* Lets n readings wait until there is a batch of them. */
static void keep_waiting(struct rmap_stats_moments *moments, const struct rmap_moment_ones *ones,
                         size_t n)
{
    centred(ones->value, n, ones->centre, ones->per_scale, moments->waiting + moments->n_waiting);
    moments->n_waiting += n;
    for (size_t k = 0; ones->place && k < n; k++)
        ones->count[ones->place[k]]++;
    if (moments->n_waiting == RMAP_MOMENT_BATCH)
        flush_ones(moments);
}

void rmap_stats_moments_add_ones(struct rmap_stats_moments *moments,
                                 const struct rmap_moment_ones *ones)
{
    struct rmap_moment_ones rest = *ones;
    while (rest.n > 0) {
        const size_t room = RMAP_MOMENT_BATCH - moments->n_waiting;
        const size_t some = rest.n < room ? rest.n : room;
        const bool whole = some == RMAP_MOMENT_BATCH || (rest.are_last && moments->n_waiting == 0);
        rest.next = some < rest.n ? rest.value + some : ones->next;
        if (whole)
            add_batch(moments, &rest, some);
        else
            keep_waiting(moments, &rest, some);
        rest.value += some;
        rest.place = rest.place ? rest.place + some : NULL;
        rest.n -= some;
    }
}

void rmap_stats_moments_flush(struct rmap_stats_moments *moments)
{
    if (moments->n_waiting > 0)
        flush_ones(moments);
    if (moments->n_cluster == 0)
        return;
    for (size_t k = 0; k < RMAP_MOMENTS; k++)
        rmap_exact_sum_add(&moments->total[k], moments->its_total[k]);
    for (size_t k = 0; k < RMAP_MOMENT_PRODUCTS; k++)
        rmap_exact_sum_add(&moments->product[k], moments->its_product[k]);
    memset(moments->its_total, 0, sizeof moments->its_total);
    memset(moments->its_product, 0, sizeof moments->its_product);
    moments->n_cluster = 0;
}

void rmap_stats_moments_add(struct rmap_stats_moments *moments, const double q[RMAP_MOMENTS])
{
    double *product = moments->its_product;
    for (size_t j = 0; j < RMAP_MOMENTS; j++) {
        moments->its_total[j] += q[j];
        for (size_t k = j; k < RMAP_MOMENTS; k++)
            *product++ += q[j] * q[k];
    }
    moments->n_cluster++;
}

void rmap_stats_moments_merge(struct rmap_stats_moments *into,
                              const struct rmap_stats_moments *from)
{
    for (size_t k = 0; k < RMAP_MOMENT_POWERS; k++)
        rmap_exact_sum_merge(&into->power[k], &from->power[k]);
    for (size_t k = 0; k < RMAP_MOMENTS; k++)
        if (!rmap_exact_sum_is_empty(&from->total[k]))
            rmap_exact_sum_merge(&into->total[k], &from->total[k]);
    for (size_t k = 0; k < RMAP_MOMENT_PRODUCTS; k++)
        if (!rmap_exact_sum_is_empty(&from->product[k]))
            rmap_exact_sum_merge(&into->product[k], &from->product[k]);
}

static double both(const struct rmap_exact_sum *a, const struct rmap_exact_sum *b)
{
    if (rmap_exact_sum_is_empty(b)) /* each reading a cluster of its own, mostly */
        return rmap_exact_sum_value(a);
    struct rmap_exact_sum sum = *a;
    rmap_exact_sum_merge(&sum, b);
    return rmap_exact_sum_value(&sum);
}

void rmap_stats_moments_value(const struct rmap_stats_moments *moments, double total[RMAP_MOMENTS],
                              double product[RMAP_MOMENTS][RMAP_MOMENTS])
{
    const struct rmap_exact_sum *one = moments->product;
    for (size_t j = 0; j < RMAP_MOMENTS; j++) {
        total[j] = both(&moments->power[j], &moments->total[j]);
        for (size_t k = j; k < RMAP_MOMENTS; k++)
            product[j][k] = product[k][j] = both(&moments->power[j + k], one++);
    }
}
