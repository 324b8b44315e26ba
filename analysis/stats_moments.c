/* SPDX-License-Identifier: MIT */
#include "analysis/stats_moments.h"

#include "base/wide.h"

/* A batch's powers are added without rounding, in any order: each term of [-1, 1] is split into a
 * multiple of 2^-43 and one of 2^-86 (what is left below is cut off, term by term), and 1024 of
 * either fit into 53 bits. Adding and subtracting 1.5 2^(52 - 43) rounds to such multiples. */
enum { LANES = 8, N_SUM = RMAP_MOMENT_POWERS - 1 };

RMAP_WIDE static void sum_power(const double *restrict u, double *restrict power,
                                double *restrict high, double *restrict low)
{
    const double high_shift = 0x1.8p9, low_shift = 0x1.8p-34;
    for (size_t i = 0; i < RMAP_MOMENT_BATCH; i += LANES)
        for (size_t lane = 0; lane < LANES; lane++) {
            const double own = power[i + lane] * u[i + lane];
            const double upper = (own + high_shift) - high_shift;
            power[i + lane] = own;
            high[lane] += upper;
            low[lane] += ((own - upper) + low_shift) - low_shift;
        }
}

void rmap_stats_moments_flush(struct rmap_stats_moments *moments)
{
    double power[RMAP_MOMENT_BATCH];
    if (moments->n_waiting == 0)
        return;
    for (size_t i = moments->n_waiting; i < RMAP_MOMENT_BATCH; i++)
        moments->waiting[i] = 0.0;
    for (size_t i = 0; i < RMAP_MOMENT_BATCH; i++)
        power[i] = 1.0;
    rmap_exact_sum_add(&moments->power[0], (double)moments->n_waiting);
    for (size_t k = 1; k <= N_SUM; k++) {
        double high[LANES] = {0.0}, low[LANES] = {0.0};
        sum_power(moments->waiting, power, high, low);
        for (size_t lane = 0; lane < LANES; lane++) {
            rmap_exact_sum_add(&moments->power[k], high[lane]);
            rmap_exact_sum_add(&moments->power[k], low[lane]);
        }
    }
    moments->n_waiting = 0;
}

void rmap_stats_moments_add(struct rmap_stats_moments *moments, const double q[RMAP_MOMENTS])
{
    struct rmap_exact_sum *product = moments->product;
    for (size_t j = 0; j < RMAP_MOMENTS; j++) {
        rmap_exact_sum_add(&moments->total[j], q[j]);
        for (size_t k = j; k < RMAP_MOMENTS; k++)
            rmap_exact_sum_add(product++, q[j] * q[k]);
    }
}

void rmap_stats_moments_merge(struct rmap_stats_moments *into,
                              const struct rmap_stats_moments *from)
{
    for (size_t i = 0; i < from->n_waiting; i++)
        rmap_stats_moments_add_one(into, from->waiting[i]);
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

void rmap_stats_moments_value(struct rmap_stats_moments *moments, double total[RMAP_MOMENTS],
                              double product[RMAP_MOMENTS][RMAP_MOMENTS])
{
    const struct rmap_exact_sum *one = moments->product;
    rmap_stats_moments_flush(moments);
    for (size_t j = 0; j < RMAP_MOMENTS; j++) {
        total[j] = both(&moments->power[j], &moments->total[j]);
        for (size_t k = j; k < RMAP_MOMENTS; k++)
            product[j][k] = product[k][j] = both(&moments->power[j + k], one++);
    }
}
