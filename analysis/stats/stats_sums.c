/* SPDX-License-Identifier: MIT
 *
 * Each cluster goes to the moments and fine bins of its class, and once to every cell that it has
 * readings in.
 */
#include "analysis/stats/stats_sums.h"

#include <stdlib.h>
#include <string.h>

#include "analysis/query/quantity_read.h"
#include "base/alloc.h"

/* A reading of a cluster in its cell. */
struct rmap_stats_place {
    size_t cell;
    double weight;
};

/* The arrays that are merged and sent. */
struct extent {
    size_t moments, cell, fine; /* elements */
};

static struct extent extent_of(const struct rmap_stats_plan *plan)
{
    const struct rmap_stats_setup *setup = plan->setup;
    const size_t n_moments = setup->n_class * setup->quantities->n;
    return (struct extent){n_moments, setup->n_class * (plan->n_cell + RMAP_STATS_BEYOND),
                           n_moments * plan->n_fine};
}

double rmap_stats_sums_nbytes(const struct rmap_stats_setup *setup, double n_cell, double n_fine)
{
    const double n_class = (double)setup->n_class, n_quantity = (double)setup->quantities->n;
    return n_class * (n_quantity * (sizeof(struct rmap_stats_moments) + n_fine * sizeof(double)) +
                      (n_cell + RMAP_STATS_BEYOND) * sizeof(struct rmap_stats_cell));
}

static void destroy(void *state)
{
    struct rmap_stats_sums *self = state;
    if (!self)
        return;
    rmap_stats_reader_fini(&self->reader);
    rmap_free(self->moments);
    rmap_free(self->cell);
    rmap_free(self->fine);
    rmap_free(self->place);
    rmap_free(self);
}

static enum rmap_status create(const void *context, void **state_ret, struct rmap_error *err)
{
    const struct rmap_stats_plan *plan = context;
    const struct extent extent = extent_of(plan);
    struct rmap_stats_sums *self = rmap_alloc(1, sizeof *self);
    if (self) {
        self->plan = plan;
        self->moments = rmap_alloc(extent.moments, sizeof *self->moments);
        self->cell = rmap_alloc(extent.cell, sizeof *self->cell);
        self->fine = rmap_alloc(extent.fine, sizeof *self->fine);
    }
    if (!self || !self->moments || !self->cell || !self->fine) {
        destroy(self);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a histogram of %zu bins",
                              plan->n_cell);
    }
    *state_ret = self;
    return RMAP_OK;
}

/* Cell of reading k of a block; of two quantities, n_cell + RMAP_STATS_ABOVE is outside. */
static size_t cell_of(const struct rmap_stats_plan *plan, const struct rmap_stats_block *block,
                      size_t k)
{
    const size_t x = rmap_bin_of(&plan->bins[0], block->value[0][k]);
    if (plan->setup->quantities->n == 1)
        return x == RMAP_BIN_BELOW   ? plan->n_cell + RMAP_STATS_BELOW
               : x == RMAP_BIN_ABOVE ? plan->n_cell + RMAP_STATS_ABOVE
                                     : x;
    const size_t y = rmap_bin_of(&plan->bins[1], block->value[1][k]);
    if (x >= plan->bins[0].n || y >= plan->bins[1].n)
        return plan->n_cell + RMAP_STATS_ABOVE;
    return x + plan->bins[0].n * y;
}

static int compare_places(const void *a, const void *b)
{
    size_t x = ((const struct rmap_stats_place *)a)->cell;
    size_t y = ((const struct rmap_stats_place *)b)->cell;
    return (x > y) - (x < y);
}

static void add_to_cell(struct rmap_stats_cell *cell, double weight)
{
    cell->rays += 1.0;
    cell->weight += weight;
    cell->squared += rmap_stats_rounded(weight * weight);
}

/* What a cluster [first, end) adds to cells: its readings in one cell go together. */
static enum rmap_status add_to_cells(struct rmap_stats_sums *self,
                                     const struct rmap_stats_block *block, size_t first, size_t end,
                                     struct rmap_stats_cell *cell, struct rmap_error *err)
{
    const size_t n = end - first;
    if (n == 1) {
        add_to_cell(&cell[cell_of(self->plan, block, first)], rmap_stats_weight(block, first));
        return RMAP_OK;
    }
    enum rmap_status st = RMAP_RESERVE(self->place, self->place_cap, n, err);
    struct rmap_stats_place *place = self->place;
    if (st != RMAP_OK)
        return st;
    for (size_t k = 0; k < n; k++)
        place[k] = (struct rmap_stats_place){cell_of(self->plan, block, first + k),
                                             rmap_stats_weight(block, first + k)};
    qsort(place, n, sizeof *place, compare_places);
    for (size_t k = 0; k < n;) {
        const size_t same = place[k].cell;
        double weight = 0.0;
        for (; k < n && place[k].cell == same; k++)
            weight += place[k].weight;
        add_to_cell(&cell[same], weight);
    }
    return RMAP_OK;
}

static void add_to_moments(const struct rmap_stats_plan *plan, const struct rmap_stats_block *block,
                           size_t quantity, size_t first, size_t end,
                           struct rmap_stats_moments *moments)
{
    double q[RMAP_MOMENTS] = {0.0};
    for (size_t k = first; k < end; k++) {
        double u = (block->value[quantity][k] - plan->centre[quantity]) * plan->per_scale[quantity];
        double power = block->weight ? block->weight[k] : 1.0;
        for (size_t j = 0; j < RMAP_MOMENTS; j++, power *= u)
            q[j] += power;
    }
    rmap_stats_moments_add(moments, q);
}

enum rmap_status rmap_stats_sums_add(struct rmap_stats_sums *self,
                                     const struct rmap_stats_block *block, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_stats_plan *plan = self->plan;
    const size_t n_quantity = plan->setup->quantities->n;
    for (size_t first = 0, end = 0; first < block->n; first = end) {
        const size_t class = rmap_stats_class(block, first);
        double *fine = self->fine + class * n_quantity * plan->n_fine;
        end = rmap_stats_cluster_end(block, first);
        for (size_t i = 0; i < n_quantity; i++, fine += plan->n_fine) {
            add_to_moments(plan, block, i, first, end, &self->moments[class * n_quantity + i]);
            for (size_t k = first; k < end; k++)
                fine[rmap_stats_fine(plan, i, block->value[i][k])] += rmap_stats_weight(block, k);
        }
        RMAP_TRY(add_to_cells(self, block, first, end,
                              self->cell + class * (plan->n_cell + RMAP_STATS_BEYOND), err));
    }
    for (size_t i = 0; i < plan->setup->n_class * n_quantity; i++)
        rmap_stats_moments_flush(&self->moments[i]);
out:
    return st;
}

static enum rmap_status add(void *state, const struct rmap_matched *rays, struct rmap_error *err)
{
    struct rmap_stats_sums *self = state;
    struct rmap_stats_block block;
    enum rmap_status st =
        rmap_stats_reader_read(&self->reader, self->plan->setup, rays, &block, err);
    return st == RMAP_OK ? rmap_stats_sums_add(self, &block, err) : st;
}

static enum rmap_status merge(void *into, void *from, struct rmap_error *err)
{
    struct rmap_stats_sums *self = into;
    const struct rmap_stats_sums *other = from;
    const struct extent extent = extent_of(self->plan);
    (void)err;
    for (size_t i = 0; i < extent.moments; i++)
        rmap_stats_moments_merge(&self->moments[i], &other->moments[i]);
    for (size_t i = 0; i < extent.cell; i++) {
        self->cell[i].rays += other->cell[i].rays;
        self->cell[i].weight += other->cell[i].weight;
        self->cell[i].squared += other->cell[i].squared;
    }
    for (size_t i = 0; i < extent.fine; i++)
        self->fine[i] += other->fine[i];
    return RMAP_OK;
}

static size_t blocks(const void *state, struct rmap_fold_block block[RMAP_FOLD_BLOCKS_MAX])
{
    const struct rmap_stats_sums *self = state;
    const struct extent extent = extent_of(self->plan);
    block[0] = (struct rmap_fold_block){self->moments, extent.moments * sizeof *self->moments};
    block[1] = (struct rmap_fold_block){self->cell, extent.cell * sizeof *self->cell};
    block[2] = (struct rmap_fold_block){self->fine, extent.fine * sizeof *self->fine};
    return 3;
}

static bool may_count(const void *context, const struct rmap_portion_info *portion)
{
    const struct rmap_stats_plan *plan = context;
    return rmap_quantities_may_count(plan->setup->quantities, portion);
}

const struct rmap_fold_kind rmap_stats_sums_kind = {.create = create,
                                                    .destroy = destroy,
                                                    .add = add,
                                                    .merge = merge,
                                                    .blocks = blocks,
                                                    .may_count = may_count};
