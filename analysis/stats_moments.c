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

/* Sums of u, u^2, ... of VECTOR of the LANES, from `lane` on. n: a multiple of LANES. */
RMAP_WIDE static void sum_powers(const double *u, size_t n, size_t lane, vector sum[POWERS])
{
    vector own[POWERS] = {{0.0}};
    for (size_t i = lane; i < n; i += LANES) {
        vector its, power;
        memcpy(&its, u + i, sizeof its);
        power = its;
        own[0] += power;
        for (int k = 1; k < POWERS; k++) {
            power *= its;
            own[k] += power;
        }
    }
    memcpy(sum, own, sizeof own);
}

static void flush_ones(struct rmap_stats_moments *moments)
{
    vector sum[LANES / VECTOR][POWERS];
    const size_t n = (moments->n_waiting + LANES - 1) / LANES * LANES;
    for (size_t i = moments->n_waiting; i < n; i++)
        moments->waiting[i] = 0.0;
    for (size_t v = 0; v < LANES / VECTOR; v++)
        sum_powers(moments->waiting, n, v * VECTOR, sum[v]);
    rmap_exact_sum_add(&moments->power[0], (double)moments->n_waiting);
    for (size_t k = 0; k < POWERS; k++) {
        double lane[LANES];
        for (size_t v = 0; v < LANES / VECTOR; v++)
            memcpy(lane + v * VECTOR, &sum[v][k], sizeof sum[v][k]);
        for (size_t half = LANES / 2; half > 0; half /= 2)
            for (size_t i = 0; i < half; i++)
                lane[i] += lane[i + half];
        rmap_exact_sum_add(&moments->power[k + 1], lane[0]);
    }
    moments->n_waiting = 0;
}

void rmap_stats_moments_add_ones(struct rmap_stats_moments *moments, const double *value, size_t n,
                                 double centre, double per_scale)
{
    while (n > 0) {
        const size_t room = RMAP_MOMENT_BATCH - moments->n_waiting, some = n < room ? n : room;
        centred(value, some, centre, per_scale, moments->waiting + moments->n_waiting);
        moments->n_waiting += some;
        value += some;
        n -= some;
        if (moments->n_waiting == RMAP_MOMENT_BATCH)
            flush_ones(moments);
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
        rmap_exact_sum_merge(&into->total[k], &from->total[k]);
    for (size_t k = 0; k < RMAP_MOMENT_PRODUCTS; k++)
        rmap_exact_sum_merge(&into->product[k], &from->product[k]);
}

static double both(const struct rmap_exact_sum *a, const struct rmap_exact_sum *b)
{
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
