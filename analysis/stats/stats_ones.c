/* SPDX-License-Identifier: MIT */
#include "analysis/stats/stats_ones.h"

#include <float.h>
#include <math.h>

#include "analysis/stats/stats_places.h"
#include "base/wide.h"

/* Bins of the histogram; -1 for what lies beyond them or within `slack` of an edge, counted in
 * bins. */
RMAP_WIDE static void sure_places(const double *restrict value, size_t n,
                                  const struct rmap_bins *bins, double slack,
                                  int32_t *restrict place)
{
    const double low = bins->edge[0], per = bins->per, last = (double)(bins->n - 1);
    for (size_t k = 0; k < n; k++) {
        const double at = (value[k] - low) * per;
        double within = at > 0.0 ? at : 0.0;
        within = within < last ? within : last;
        const int32_t guess = (int32_t)within;
        const double part = at - (double)guess;
        const int32_t doubt = -(int32_t) !((part > slack) & (part < 1.0 - slack));
        place[k] = guess | doubt;
    }
}

static void add_to_cells(const struct rmap_stats_plan *plan, const struct rmap_stats_block *block,
                         const struct rmap_stats_ones *ones, double *cell)
{
    const struct rmap_bins *bins = &plan->bins[0];
    int32_t place[RMAP_STATS_ONES_MOST];
    if (plan->n_fine_per_cell > 0)
        return; /* rmap_stats_sums_finish */
    if (plan->setup->quantities->n > 1 || !bins->uniform || bins->n > INT32_MAX) {
        for (size_t k = ones->first; k < ones->first + ones->n; k++)
            cell[rmap_stats_cell_of(plan, block, k)] += 1.0;
        return;
    }
    /* Edges are rounded, and so are places: by some parts in 2^52 of the numbers in them. */
    const double reach = fabs(bins->edge[0]) + fabs(bins->edge[bins->n]);
    const double slack = 64.0 * DBL_EPSILON * (reach * bins->per + (double)bins->n);
    sure_places(block->value[0] + ones->first, ones->n, bins, slack, place);
    for (size_t k = 0; k < ones->n; k++)
        cell[place[k] >= 0 ? (size_t)place[k] : rmap_stats_cell_of(plan, block, ones->first + k)] +=
            1.0;
}

void rmap_stats_sums_add_ones(struct rmap_stats_sums *self, const struct rmap_stats_block *block,
                              const struct rmap_stats_ones *ones)
{
    const struct rmap_stats_plan *plan = self->plan;
    const size_t n_quantity = plan->setup->quantities->n;
    uint16_t own[RMAP_STATS_ONES_MOST];
    for (size_t i = 0; i < n_quantity; i++) {
        const double *value = block->value[i] + ones->first;
        const size_t row = ones->class * n_quantity + i;
        uint16_t *place = block->place[i] ? block->place[i] + ones->first : own;
        rmap_stats_fine_places(plan, i, value, ones->n, place);
        const struct rmap_moment_ones its = {.value = value,
                                             .n = ones->n,
                                             .centre = plan->centre[i],
                                             .per_scale = plan->per_scale[i],
                                             .are_last = ones->are_last,
                                             .place = place,
                                             .count = self->fine_single + row * plan->n_fine,
                                             .next = ones->next[i]};
        rmap_stats_moments_add_ones(&self->moments[row], &its);
    }
    add_to_cells(plan, block, ones,
                 self->single + ones->class * (plan->n_cell + RMAP_STATS_BEYOND));
}

struct rmap_stats_ones rmap_stats_ones_at(const struct rmap_stats_block *block, size_t first,
                                          size_t last)
{
    const uint32_t class = rmap_stats_class(block->tag[first]), own = class | RMAP_STATS_FIRST;
    const double *weight = block->weight;
    size_t end = first;
    last = last < first + RMAP_STATS_ONES_MOST ? last : first + RMAP_STATS_ONES_MOST;
    if (!weight || weight[first] == 1.0)
        for (end = first + 1; end < last && block->tag[end] == own;)
            end++;
    for (size_t k = first; weight && k < end; k++)
        end = weight[k] == 1.0 ? end : k;
    if (end > first && end < block->n && !(block->tag[end] & RMAP_STATS_FIRST))
        end--; /* its last one goes on */
    return (struct rmap_stats_ones){.class = class, .first = first, .n = end - first};
}
