/* SPDX-License-Identifier: MIT
 *
 * Sums over cells of what rays leave in them, as whole numbers.
 */
#include "analysis/detector/cell_sums.h"

#include <math.h>

#include "analysis/table/flux_error.h"
#include "base/alloc.h"

static const double AMOUNT = 67108864.0, SQUARE = 16777216.0; /* 2^26, 2^24 */

size_t rmap_cell_sums_nbytes(size_t n_source, size_t n_cell)
{
    return (2 * n_source + 2) * n_cell * sizeof(uint64_t);
}

enum rmap_status rmap_cell_sums_init(struct rmap_cell_sums *sums, size_t n_source, size_t n_cell,
                                     struct rmap_error *err)
{
    *sums = (struct rmap_cell_sums){.n_source = n_source, .n_cell = n_cell};
    sums->amount = rmap_alloc(n_source * n_cell + 1, sizeof *sums->amount);
    sums->squared = rmap_alloc(n_source * n_cell + 1, sizeof *sums->squared);
    sums->total = rmap_alloc(2 * n_source + 1, sizeof *sums->total);
    sums->pending = rmap_alloc(n_cell + 1, sizeof *sums->pending);
    sums->touched = rmap_alloc(n_cell + 1, sizeof *sums->touched);
    if (sums->amount && sums->squared && sums->total && sums->pending && sums->touched)
        return RMAP_OK;
    rmap_cell_sums_fini(sums);
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory for sums in %zu cells", n_cell);
}

void rmap_cell_sums_fini(struct rmap_cell_sums *sums)
{
    rmap_free(sums->amount);
    rmap_free(sums->squared);
    rmap_free(sums->total);
    rmap_free(sums->pending);
    rmap_free(sums->touched);
    *sums = (struct rmap_cell_sums){0};
}

void rmap_cell_sums_add(struct rmap_cell_sums *sums, size_t cell, double amount)
{
    const uint64_t parts = (uint64_t)llround(amount * AMOUNT);
    if (parts == 0)
        return;
    if (sums->pending[cell] == 0)
        sums->touched[sums->n_touched++] = cell;
    sums->pending[cell] += parts;
}

void rmap_cell_sums_end_ray(struct rmap_cell_sums *sums, size_t source)
{
    uint64_t all = 0;
    for (size_t k = 0; k < sums->n_touched; k++) {
        const size_t cell = sums->touched[k];
        const double units = (double)sums->pending[cell] / AMOUNT;
        sums->amount[source * sums->n_cell + cell] += sums->pending[cell];
        sums->squared[source * sums->n_cell + cell] += (uint64_t)llround(units * units * SQUARE);
        all += sums->pending[cell];
        sums->pending[cell] = 0;
    }
    if (sums->n_touched > 0) {
        const double units = (double)all / AMOUNT;
        rmap_exact_sum_add(&sums->total[2 * source], units);
        rmap_exact_sum_add(&sums->total[2 * source + 1], units * units);
    }
    sums->n_touched = 0;
}

void rmap_cell_sums_merge(struct rmap_cell_sums *into, const struct rmap_cell_sums *from)
{
    for (size_t i = 0; i < into->n_source * into->n_cell; i++) {
        into->amount[i] += from->amount[i];
        into->squared[i] += from->squared[i];
    }
    for (size_t i = 0; i < 2 * into->n_source; i++)
        rmap_exact_sum_merge(&into->total[i], &from->total[i]);
}

void rmap_cell_sums_blocks(const struct rmap_cell_sums *sums,
                           struct rmap_fold_block block[RMAP_CELL_SUMS_BLOCKS])
{
    const size_t n = sums->n_source * sums->n_cell;
    block[0] = (struct rmap_fold_block){sums->amount, n * sizeof *sums->amount};
    block[1] = (struct rmap_fold_block){sums->squared, n * sizeof *sums->squared};
    block[2] = (struct rmap_fold_block){sums->total, 2 * sums->n_source * sizeof *sums->total};
}

void rmap_cell_sums_flux(const struct rmap_cell_sums *sums, const struct rmap_map *map, size_t cell,
                         double *flux_ret, double *error_ret)
{
    double variance = 0.0;
    *flux_ret = 0.0;
    for (size_t s = 0; s < sums->n_source; s++) {
        const size_t i = s * sums->n_cell + cell;
        const bool all = cell == sums->n_cell;
        const double w =
            all ? rmap_exact_sum_value(&sums->total[2 * s]) : (double)sums->amount[i] / AMOUNT;
        const double w2 =
            all ? rmap_exact_sum_value(&sums->total[2 * s + 1]) : (double)sums->squared[i] / SQUARE;
        const double per_weight = rmap_map_flux_per_weight(map)[s];
        *flux_ret += per_weight * w;
        variance += rmap_flux_variance(per_weight, rmap_map_emitted(map)[s], w, w2);
    }
    *error_ret = rmap_flux_error(variance);
}
