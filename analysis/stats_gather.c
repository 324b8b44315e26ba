/* SPDX-License-Identifier: MIT */
#include "analysis/stats_gather.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "base/wide.h"

static void destroy(void *state)
{
    struct rmap_stats_gathered *self = state;
    if (!self)
        return;
    rmap_stats_reader_fini(&self->reader);
    for (size_t i = 0; i < RMAP_QUANTITIES_MAX; i++)
        rmap_free(self->value[i]);
    rmap_free(self->tag);
    rmap_free(self->weight);
    rmap_free(self->range);
    rmap_free(self);
}

static size_t n_range(const struct rmap_stats_setup *setup)
{
    return setup->n_group * setup->quantities->n;
}

static enum rmap_status create(const void *context, void **state_ret, struct rmap_error *err)
{
    const struct rmap_stats_setup *setup = context;
    struct rmap_stats_gathered *self = rmap_alloc(1, sizeof *self);
    if (self)
        self->range = rmap_alloc(n_range(setup) + 1, sizeof *self->range);
    if (!self || !self->range) {
        destroy(self);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for statistics of %zu groups",
                              setup->n_group);
    }
    self->setup = setup;
    const double infinity = (double)INFINITY;
    for (size_t i = 0; i < n_range(setup); i++)
        self->range[i] = (struct rmap_stats_range){infinity, -infinity, infinity, 0, 0};
    *state_ret = self;
    return RMAP_OK;
}

static size_t row_nbytes(const struct rmap_stats_gathered *self)
{
    return sizeof *self->tag + self->setup->quantities->n * sizeof(double) +
           (self->weight ? sizeof(double) : 0);
}

static void drop(struct rmap_stats_gathered *self)
{
    for (size_t i = 0; i < RMAP_QUANTITIES_MAX; i++) {
        rmap_free(self->value[i]);
        self->value[i] = NULL;
        self->value_cap[i] = 0;
    }
    rmap_free(self->tag);
    rmap_free(self->weight);
    self->tag = NULL;
    self->weight = NULL;
    self->tag_cap = self->weight_cap = self->n = 0;
    self->known.dropped = 1;
}

static enum rmap_status reserve(struct rmap_stats_gathered *self, size_t n, bool weights,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < self->setup->quantities->n && st == RMAP_OK; i++) {
        void *block = self->value[i];
        st = rmap_reserve(&block, &self->value_cap[i], n, sizeof *self->value[i], err);
        self->value[i] = block;
    }
    void *tag = self->tag, *weight = self->weight;
    if (st == RMAP_OK)
        st = rmap_reserve(&tag, &self->tag_cap, n, sizeof *self->tag, err);
    self->tag = tag;
    if (st == RMAP_OK && weights) {
        bool anew = !self->weight;
        st = rmap_reserve(&weight, &self->weight_cap, n, sizeof *self->weight, err);
        self->weight = weight;
        for (size_t k = 0; anew && st == RMAP_OK && k < self->n; k++)
            self->weight[k] = 1.0;
    }
    return st;
}

/* Keeps the block's readings, or none any more when they are too many. */
static enum rmap_status keep(struct rmap_stats_gathered *self, const struct rmap_stats_block *block,
                             struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n = self->n;
    bool weights = self->weight || block->weight;
    if (self->known.dropped || block->n == 0)
        return RMAP_OK;
    /* With weights or without, so that it does not matter who added first. */
    const size_t most_nbytes =
        sizeof *self->tag + (self->setup->quantities->n + 1) * sizeof(double);
    if (n + block->n > self->setup->budget_nbytes / most_nbytes) {
        drop(self);
        return RMAP_OK;
    }
    RMAP_TRY(reserve(self, n + block->n, weights, err));
    for (size_t i = 0; i < self->setup->quantities->n; i++)
        memcpy(self->value[i] + n, block->value[i], block->n * sizeof **block->value);
    memcpy(self->tag + n, block->tag, block->n * sizeof *block->tag);
    for (size_t k = 0; weights && k < block->n; k++)
        self->weight[n + k] = block->weight ? block->weight[k] : 1.0;
    self->n += block->n;
out:
    return st;
}

static void widen(struct rmap_stats_range *range, double low, double high, double least_positive)
{
    range->low = low < range->low ? low : range->low;
    range->high = high > range->high ? high : range->high;
    if (least_positive < range->least_positive)
        range->least_positive = least_positive;
}

static void merge_range(struct rmap_stats_range *into, const struct rmap_stats_range *from)
{
    widen(into, from->low, from->high, from->least_positive);
    into->n_reading += from->n_reading;
    into->n_cluster += from->n_cluster;
}

enum { LANES = 8 };

/* What there is to know of numbers, each lane of every LANES-th of them. */
struct measured {
    double low[LANES], high[LANES], least_positive[LANES], sum[LANES], squared[LANES];
};

RMAP_WIDE static void measure(const double *value, size_t n, struct measured *measured)
{
    struct measured m = *measured;
    for (size_t k = 0; k + LANES <= n; k += LANES)
        for (size_t lane = 0; lane < LANES; lane++) {
            const double v = value[k + lane];
            const double positive = v > 0.0 ? v : m.least_positive[lane];
            m.low[lane] = v < m.low[lane] ? v : m.low[lane];
            m.high[lane] = v > m.high[lane] ? v : m.high[lane];
            m.least_positive[lane] =
                positive < m.least_positive[lane] ? positive : m.least_positive[lane];
            m.sum[lane] += v;
            m.squared[lane] += v * v;
        }
    *measured = m;
}

RMAP_WIDE static uint32_t count_clusters(const uint32_t *tag, size_t n)
{
    uint32_t count = 0;
    for (size_t k = 0; k < n; k++)
        count += tag[k] >> 31;
    return count;
}

/* Readings [first, end) of a portion, all of one group. A portion comes as a whole, whoever adds
 * it: sums over its readings, in their order, may be rounded. */
static void look_at(struct rmap_stats_gathered *self, const struct rmap_stats_block *block,
                    size_t quantity, size_t first, size_t end, struct rmap_stats_range *range)
{
    const double infinity = (double)INFINITY;
    const double *value = block->value[quantity] + first;
    const size_t n = end - first, n_wide = n / LANES * LANES;
    struct measured m = {.sum = {0.0}};
    for (size_t lane = 0; lane < LANES; lane++) {
        m.low[lane] = m.least_positive[lane] = infinity;
        m.high[lane] = -infinity;
    }
    if (n_wide > 0)
        measure(value, n_wide, &m);
    for (size_t k = n_wide; k < n; k++) {
        const double v = value[k];
        widen(range, v, v, v > 0.0 ? v : infinity);
        m.sum[0] += v;
        m.squared[0] += v * v;
    }
    for (size_t lane = 0; lane < LANES; lane++) {
        widen(range, m.low[lane], m.high[lane], m.least_positive[lane]);
        m.sum[0] += lane > 0 ? m.sum[lane] : 0.0;
        m.squared[0] += lane > 0 ? m.squared[lane] : 0.0;
    }
    rmap_exact_sum_add(&self->known.sum[quantity], m.sum[0]);
    rmap_exact_sum_add(&self->known.squared[quantity], m.squared[0]);
    range->n_cluster += count_clusters(block->tag + first, n);
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

static void look(struct rmap_stats_gathered *self, const struct rmap_stats_block *block)
{
    const size_t n_quantity = self->setup->quantities->n;
    const size_t n_source = self->setup->n_source;
    for (size_t first = 0, end = 0; first < block->n; first = end) {
        size_t group = 0;
        end = block->n;
        if (self->setup->n_group > 1) {
            group = rmap_stats_class(block->tag[first]) / n_source;
            for (end = first + 1;
                 end < block->n && rmap_stats_class(block->tag[end]) / n_source == group;)
                end++;
        }
        for (size_t i = 0; i < n_quantity; i++)
            look_at(self, block, i, first, end, &self->range[group * n_quantity + i]);
    }
    self->known.n_several += block->n - count_alone(block->tag, block->n);
    self->known.n_reading += block->n;
    self->known.any_weight |= block->weight != NULL;
}

static enum rmap_status add(void *state, const struct rmap_matched *rays, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_stats_gathered *self = state;
    struct rmap_stats_block block;
    self->known.n_ray += rays->n_match;
    RMAP_TRY(rmap_stats_reader_read(&self->reader, self->setup, rays, &block, err));
    self->known.n_undefined += self->reader.readings.n_undefined;
    look(self, &block);
    st = keep(self, &block, err);
out:
    return st;
}

struct rmap_stats_block rmap_stats_gathered_block(const struct rmap_stats_gathered *self)
{
    return (struct rmap_stats_block){.n = self->n,
                                     .value = {self->value[0], self->value[1]},
                                     .tag = self->tag,
                                     .weight = self->weight};
}

static enum rmap_status merge(void *into, const void *from, struct rmap_error *err)
{
    struct rmap_stats_gathered *self = into;
    const struct rmap_stats_gathered *other = from;
    struct rmap_stats_known *known = &self->known;
    const struct rmap_stats_block block = rmap_stats_gathered_block(other);
    known->n_ray += other->known.n_ray;
    known->n_reading += other->known.n_reading;
    known->n_undefined += other->known.n_undefined;
    known->n_several += other->known.n_several;
    known->any_weight |= other->known.any_weight;
    for (size_t i = 0; i < RMAP_QUANTITIES_MAX; i++) {
        rmap_exact_sum_merge(&known->sum[i], &other->known.sum[i]);
        rmap_exact_sum_merge(&known->squared[i], &other->known.squared[i]);
    }
    for (size_t i = 0; i < n_range(self->setup); i++)
        merge_range(&self->range[i], &other->range[i]);
    if (other->known.dropped && !known->dropped)
        drop(self);
    return keep(self, &block, err);
}

/* Bytes: what is known, the ranges, the readings, and a byte for whether weights stand there. */
static void put(uint8_t **at, const void *data, size_t nbytes)
{
    if (nbytes > 0)
        memcpy(*at, data, nbytes);
    *at += nbytes;
}

static enum rmap_status pack(const void *state, uint8_t **bytes_ret, size_t *nbytes_ret,
                             struct rmap_error *err)
{
    const struct rmap_stats_gathered *self = state;
    const uint64_t n[2] = {self->n, self->weight != NULL};
    const size_t range_nbytes = n_range(self->setup) * sizeof *self->range;
    *nbytes_ret = sizeof self->known + range_nbytes + sizeof n + self->n * row_nbytes(self);
    uint8_t *at = *bytes_ret = rmap_alloc(*nbytes_ret, 1);
    if (!at)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu readings", self->n);
    put(&at, &self->known, sizeof self->known);
    put(&at, self->range, range_nbytes);
    put(&at, n, sizeof n);
    for (size_t i = 0; i < self->setup->quantities->n; i++)
        put(&at, self->value[i], self->n * sizeof *self->value[i]);
    put(&at, self->tag, self->n * sizeof *self->tag);
    if (self->weight)
        put(&at, self->weight, self->n * sizeof *self->weight);
    return RMAP_OK;
}

static void take(const uint8_t **at, void *data, size_t nbytes)
{
    if (nbytes > 0)
        memcpy(data, *at, nbytes);
    *at += nbytes;
}

static enum rmap_status unpack(const void *context, const uint8_t *bytes, size_t nbytes,
                               void **state_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    void *state = NULL;
    const uint8_t *at = bytes;
    uint64_t n[2];
    RMAP_TRY(create(context, &state, err));
    struct rmap_stats_gathered *self = state;
    take(&at, &self->known, sizeof self->known);
    take(&at, self->range, n_range(self->setup) * sizeof *self->range);
    take(&at, n, sizeof n);
    RMAP_TRY(reserve(self, (size_t)n[0] + 1, n[1] != 0, err));
    self->n = (size_t)n[0];
    if ((size_t)(at - bytes) + self->n * row_nbytes(self) != nbytes) {
        st = rmap_error_set(err, RMAP_INTERNAL, "another rank's readings do not fit together");
        goto out;
    }
    for (size_t i = 0; i < self->setup->quantities->n; i++)
        take(&at, self->value[i], self->n * sizeof *self->value[i]);
    take(&at, self->tag, self->n * sizeof *self->tag);
    if (self->weight)
        take(&at, self->weight, self->n * sizeof *self->weight);
    *state_ret = state;
    state = NULL;
out:
    destroy(state);
    return st;
}

static bool may_count(const void *context, const struct rmap_portion_info *portion)
{
    const struct rmap_stats_setup *setup = context;
    return !setup->all_rays || rmap_quantities_may_count(setup->quantities, portion);
}

const struct rmap_fold_kind rmap_stats_gather_kind = {.create = create,
                                                      .destroy = destroy,
                                                      .add = add,
                                                      .merge = merge,
                                                      .pack = pack,
                                                      .unpack = unpack,
                                                      .may_count = may_count};
