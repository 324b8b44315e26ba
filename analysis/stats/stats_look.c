/* SPDX-License-Identifier: MIT */
#include "analysis/stats/stats_look.h"

#include "analysis/stats/stats_measure.h"
#include "base/wide.h"

static void widen(struct rmap_stats_range *range, double low, double high, double least_positive)
{
    range->low = low < range->low ? low : range->low;
    range->high = high > range->high ? high : range->high;
    if (least_positive < range->least_positive)
        range->least_positive = least_positive;
}

void rmap_stats_range_merge(struct rmap_stats_range *into, const struct rmap_stats_range *from)
{
    widen(into, from->low, from->high, from->least_positive);
    into->n_reading += from->n_reading;
    into->n_cluster += from->n_cluster;
    rmap_exact_sum_merge(&into->sum, &from->sum);
    rmap_exact_sum_merge(&into->squared, &from->squared);
}

RMAP_WIDE static uint32_t count_clusters(const uint32_t *tag, size_t n)
{
    uint32_t count = 0;
    for (size_t k = 0; k < n; k++)
        count += tag[k] >> 31;
    return count;
}

/* Readings [first, end) of a portion, all of one group, whose range it is. */
static void look_at(struct rmap_stats_gathered *self, const struct rmap_stats_block *block,
                    size_t quantity, size_t first, size_t end, struct rmap_stats_range *range)
{
    const double *value = block->value[quantity] + first;
    const size_t n = end - first;
    const struct rmap_stats_measured m = block->is_measured && n == block->n
                                             ? block->measured[quantity]
                                             : rmap_stats_measure(value, n);
    const bool positive = m.low > 0.0 || !self->setup->logarithmic;
    widen(range, m.low, m.high, positive ? m.low : rmap_stats_least_positive(value, n));
    rmap_exact_sum_add(&range->sum, m.sum);
    rmap_exact_sum_add(&range->squared, m.squared);
    range->n_cluster += block->tag ? count_clusters(block->tag + first, n) : n;
    range->n_reading += n;
}

/* Readings that are the only one of their cluster. */
RMAP_WIDE static uint32_t count_alone(const uint32_t *tag, size_t n)
{
    uint32_t count = n > 0 ? tag[n - 1] >> 31 : 0;
    for (size_t k = 0; k + 1 < n; k++)
        count += (tag[k] & tag[k + 1]) >> 31;
    return count;
}

/* Behind the last of the readings from `first` on that are of its group. */
static size_t group_end(const struct rmap_stats_gathered *self,
                        const struct rmap_stats_block *block, size_t first, size_t *group_ret)
{
    const size_t n_source = self->setup->n_source;
    size_t end = first;
    *group_ret = 0;
    if (self->setup->n_group == 1)
        return block->n;
    if (block->tag) {
        *group_ret = rmap_stats_class(block->tag[first]) / n_source;
        while (end < block->n && rmap_stats_class(block->tag[end]) / n_source == *group_ret)
            end++;
        return end;
    }
    size_t k = 0; /* by source alone: a run is a group */
    while (block->run[k].end <= first)
        k++;
    *group_ret = block->run[k].class / n_source;
    return block->run[k].end;
}

void rmap_stats_look(struct rmap_stats_gathered *self, const struct rmap_stats_block *block)
{
    const size_t n_quantity = self->setup->quantities->n;
    for (size_t first = 0, end = 0; first < block->n; first = end) {
        size_t group;
        end = group_end(self, block, first, &group);
        for (size_t i = 0; i < n_quantity; i++)
            look_at(self, block, i, first, end, &self->range[group * n_quantity + i]);
    }
    if (block->tag)
        self->known.n_several += block->n - count_alone(block->tag, block->n);
    self->known.n_reading += block->n;
    self->known.any_weight |= block->weight != NULL;
}
