/* SPDX-License-Identifier: MIT
 *
 * Products stand row by row of the upper triangle: q_0 q_0, q_0 q_1, ..., q_4 q_4.
 */
#include "analysis/stats/stats_moments.h"

#include <string.h>

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

void rmap_stats_moments_flush(struct rmap_stats_moments *moments)
{
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

void rmap_stats_moments_merge(struct rmap_stats_moments *into,
                              const struct rmap_stats_moments *from)
{
    for (size_t k = 0; k < RMAP_MOMENTS; k++)
        rmap_exact_sum_merge(&into->total[k], &from->total[k]);
    for (size_t k = 0; k < RMAP_MOMENT_PRODUCTS; k++)
        rmap_exact_sum_merge(&into->product[k], &from->product[k]);
}

void rmap_stats_moments_value(const struct rmap_stats_moments *moments, double total[RMAP_MOMENTS],
                              double product[RMAP_MOMENTS][RMAP_MOMENTS])
{
    const struct rmap_exact_sum *one = moments->product;
    for (size_t j = 0; j < RMAP_MOMENTS; j++) {
        total[j] = rmap_exact_sum_value(&moments->total[j]);
        for (size_t k = j; k < RMAP_MOMENTS; k++)
            product[j][k] = product[k][j] = rmap_exact_sum_value(one++);
    }
}
