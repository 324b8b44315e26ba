/* SPDX-License-Identifier: MIT
 *
 * Sums over cells of what rays leave in them, per source, with the squares that standard errors
 * need: what one ray leaves in a cell, in however many parts, is one sample. Amounts are rounded to
 * 2^-26 of a unit that the caller chooses (a ray's weight, the diagonal of a voxel), and squares to
 * 2^-24 of its square, so that sums are whole numbers and do not depend on the order of adding.
 */
#ifndef RMAP_CELL_SUMS_H
#define RMAP_CELL_SUMS_H

#include "analysis/query/fold_blocks.h"
#include "base/exact_sum.h"
#include "io/map/map_reader.h"

struct rmap_cell_sums {
    size_t n_source, n_cell;
    uint64_t *amount, *squared;   /* [n_source][n_cell], in these parts of the unit */
    struct rmap_exact_sum *total; /* [n_source][2]: over all cells, and squares of that by ray */
    uint64_t *pending;            /* [n_cell] of the ray in hand */
    size_t *touched, n_touched;   /* [n_cell] where that is not 0 */
};

/* What one such sum takes, in bytes: refused beyond RMAP_CELL_SUMS_NBYTES_MAX by who asks. */
#define RMAP_CELL_SUMS_NBYTES_MAX ((size_t)1 << 30)
size_t rmap_cell_sums_nbytes(size_t n_source, size_t n_cell);

enum rmap_status rmap_cell_sums_init(struct rmap_cell_sums *sums, size_t n_source, size_t n_cell,
                                     struct rmap_error *err) RMAP_MUST_USE;
void rmap_cell_sums_fini(struct rmap_cell_sums *sums); /* zeroed: fine */

/* amount >= 0, in units: of the ray in hand; and the end of that ray. */
void rmap_cell_sums_add(struct rmap_cell_sums *sums, size_t cell, double amount);
void rmap_cell_sums_end_ray(struct rmap_cell_sums *sums, size_t source);

void rmap_cell_sums_merge(struct rmap_cell_sums *into, const struct rmap_cell_sums *from);

/* Its arrays, for those who copy them as bytes. */
enum { RMAP_CELL_SUMS_BLOCKS = 3 };
void rmap_cell_sums_blocks(const struct rmap_cell_sums *sums,
                           struct rmap_fold_block block[RMAP_CELL_SUMS_BLOCKS]);

/* Flux times units that all sources left in a cell, and its standard error; of cell n_cell: in all.
 * NaN: the error is not known (flux_error.h). */
void rmap_cell_sums_flux(const struct rmap_cell_sums *sums, const struct rmap_map *map, size_t cell,
                         double *flux_ret, double *error_ret);

#endif
