/* SPDX-License-Identifier: MIT */
#include "analysis/stats_moments.h"

#include <string.h>

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

/* What goes on beside sums of powers, which leave the processor time for it. */
struct beside {
    const uint16_t *place; /* [n] */
    uint32_t *count;       /* of each place */
    const double *next;    /* so many will be read next */
};

/* Adds to sums of u, u^2, ... of VECTOR of the LANES, from `lane` on; a part of the places. n: a
 * multiple of LANES. */
RMAP_WIDE static void sum_powers(const double *value, size_t n, size_t lane, double centre,
                                 double per_scale, const struct beside *beside, vector sum[POWERS])
{
    const size_t first = lane / VECTOR * (n / LANES) * VECTOR;
    const uint16_t *place = beside->place + first;
    const double *next = beside->next + first;
    uint32_t *count = beside->count;
    vector own[POWERS];
    memcpy(own, sum, sizeof own);
    for (size_t i = lane; i < n; i += LANES, place += VECTOR, next += VECTOR) {
        vector its, power;
        memcpy(&its, value + i, sizeof its);
        its = (its - centre) * per_scale;
        power = its;
        own[0] += power;
        for (int k = 1; k < POWERS; k++) {
            power *= its;
            own[k] += power;
        }
        for (int k = 0; k < VECTOR; k++)
            count[place[k]]++;
        __builtin_prefetch(next);
    }
    memcpy(sum, own, sizeof own);
}

/* Sums over the lanes: by halves. */
static double sum_lanes(const vector lanes[LANES / VECTOR])
{
    const vector four = (lanes[0] + lanes[2]) + (lanes[1] + lanes[3]);
    return (four[0] + four[2]) + (four[1] + four[3]);
}

/* For sums beside which nothing is counted. */
static const uint16_t nowhere[RMAP_MOMENT_BATCH] = {0};

/* A batch of n readings; up to a multiple of LANES such follow that u is 0. */
static void add_batch(struct rmap_stats_moments *moments, const struct rmap_moment_ones *ones,
                      size_t n)
{
    vector sum[LANES / VECTOR][POWERS] = {{{0.0}}};
    double tail[LANES];
    uint32_t ignored = 0;
    const size_t n_wide = n / LANES * LANES;
    const struct beside beside = {ones->place ? ones->place : nowhere,
                                  ones->place ? ones->count : &ignored,
                                  ones->next ? ones->next : ones->value};
    for (size_t v = 0; v < LANES / VECTOR; v++)
        sum_powers(ones->value, n_wide, v * VECTOR, ones->centre, ones->per_scale, &beside, sum[v]);
    for (size_t k = 0; k < LANES; k++)
        tail[k] = n_wide + k < n ? ones->value[n_wide + k] : ones->centre;
    const struct beside none = {nowhere, &ignored, tail};
    for (size_t v = 0; n_wide < n && v < LANES / VECTOR; v++)
        sum_powers(tail, LANES, v * VECTOR, ones->centre, ones->per_scale, &none, sum[v]);
    for (size_t k = n_wide; ones->place && k < n; k++)
        ones->count[ones->place[k]]++;
    rmap_exact_sum_add(&moments->power[0], (double)n);
    for (size_t k = 0; k < POWERS; k++) {
        const vector lanes[] = {sum[0][k], sum[1][k], sum[2][k], sum[3][k]};
        rmap_exact_sum_add(&moments->power[k + 1], sum_lanes(lanes));
    }
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
