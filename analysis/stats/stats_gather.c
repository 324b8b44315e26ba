/* SPDX-License-Identifier: MIT
 *
 * Ranges are merged; readings in memory change hands where they are.
 */
#include "analysis/stats/stats_gather.h"

#include <math.h>
#include <string.h>

#include "analysis/query/quantity_read.h"
#include "base/alloc.h"

static size_t n_range(const struct rmap_stats_setup *setup)
{
    return setup->n_group * setup->quantities->n;
}

static void drop_parts(struct rmap_stats_gathered *self)
{
    for (size_t p = 0; p < self->n_part; p++)
        rmap_free(self->part[p].data);
    self->n = self->n_part = 0;
}

static void destroy(void *state)
{
    struct rmap_stats_gathered *self = state;
    if (!self)
        return;
    rmap_stats_reader_fini(&self->reader);
    drop_parts(self);
    rmap_free(self->part);
    rmap_free(self->range);
    rmap_free(self);
}

static enum rmap_status create(const void *context, void **state_ret, struct rmap_error *err)
{
    const struct rmap_stats_setup *setup = context;
    const double infinity = (double)INFINITY;
    struct rmap_stats_gathered *self = rmap_alloc(1, sizeof *self);
    if (self)
        self->range = rmap_alloc(n_range(setup) + 1, sizeof *self->range);
    if (!self || !self->range) {
        destroy(self);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for statistics of %zu groups",
                              setup->n_group);
    }
    self->setup = setup;
    for (size_t i = 0; i < n_range(setup); i++)
        self->range[i] = (struct rmap_stats_range){
            .low = infinity, .high = -infinity, .least_positive = infinity};
    *state_ret = self;
    return RMAP_OK;
}

/* ---- readings in memory ---- */

static void drop(struct rmap_stats_gathered *self)
{
    drop_parts(self);
    self->known.dropped = 1;
}

static bool fits(const struct rmap_stats_gathered *self, size_t n)
{
    /* With weights or without, so that it does not matter who added first. */
    const size_t most_nbytes = sizeof(uint32_t) + (self->setup->quantities->n + 1) * sizeof(double);
    return !self->known.dropped && self->n + n <= self->setup->budget_nbytes / most_nbytes;
}

static size_t part_nbytes(const struct rmap_stats_setup *setup, size_t n, bool has_weight)
{
    return n * ((setup->quantities->n + has_weight) * sizeof(double) + sizeof(uint32_t));
}

struct rmap_stats_block rmap_stats_gathered_block(const struct rmap_stats_gathered *self,
                                                  size_t index)
{
    const struct rmap_stats_part *part = &self->part[index];
    const size_t n_quantity = self->setup->quantities->n;
    struct rmap_stats_block block = {.n = part->n};
    const double *at = part->data;
    for (size_t i = 0; i < n_quantity; i++, at += part->n)
        block.value[i] = at;
    if (part->has_weight) {
        block.weight = at;
        at += part->n;
    }
    block.tag = (const uint32_t *)(const void *)at;
    return block;
}

/* Makes room for a part, its readings to be filled in. RMAP_SYSTEM. */
static enum rmap_status add_part(struct rmap_stats_gathered *self, size_t n, bool has_weight,
                                 struct rmap_stats_part **part_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(RMAP_RESERVE(self->part, self->part_cap, self->n_part + 1, err));
    double *data = rmap_alloc_unset(part_nbytes(self->setup, n, has_weight), 1);
    if (!data)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu readings", n);
    *part_ret = &self->part[self->n_part++];
    **part_ret = (struct rmap_stats_part){n, has_weight, data};
    self->n += n;
out:
    return st;
}

/* Keeps the block's readings, or none any more when they are too many. */
static enum rmap_status keep(struct rmap_stats_gathered *self, const struct rmap_stats_block *block,
                             struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_stats_part *part = NULL;
    if (self->known.dropped || block->n == 0)
        return RMAP_OK;
    if (!fits(self, block->n)) {
        drop(self);
        return RMAP_OK;
    }
    RMAP_TRY(add_part(self, block->n, block->weight != NULL, &part, err));
    double *at = part->data;
    for (size_t i = 0; i < self->setup->quantities->n; i++, at += part->n)
        memcpy(at, block->value[i], part->n * sizeof *at);
    if (block->weight) {
        memcpy(at, block->weight, part->n * sizeof *at);
        at += part->n;
    }
    memcpy(at, block->tag, part->n * sizeof *block->tag);
out:
    return st;
}

/* ---- ranges ---- */

/* Readings [first, end) of a portion, all of one group, whose range it is. */
static void look_at(const double *value, size_t n, bool logarithmic, struct rmap_stats_range *range)
{
    double low = range->low, high = range->high, sum = 0.0, squared = 0.0;
    for (size_t k = 0; k < n; k++) {
        low = value[k] < low ? value[k] : low;
        high = value[k] > high ? value[k] : high;
        sum += value[k];
        squared += value[k] * value[k];
    }
    for (size_t k = 0; logarithmic && k < n; k++)
        if (value[k] > 0.0 && value[k] < range->least_positive)
            range->least_positive = value[k];
    range->low = low;
    range->high = high;
    range->n_reading += n;
    rmap_exact_sum_add(&range->sum, sum);
    rmap_exact_sum_add(&range->squared, squared);
}

static void merge_range(struct rmap_stats_range *into, const struct rmap_stats_range *from)
{
    into->low = fmin(into->low, from->low);
    into->high = fmax(into->high, from->high);
    into->least_positive = fmin(into->least_positive, from->least_positive);
    into->n_reading += from->n_reading;
    into->n_cluster += from->n_cluster;
    rmap_exact_sum_merge(&into->sum, &from->sum);
    rmap_exact_sum_merge(&into->squared, &from->squared);
}

/* Counts clusters of every group, and readings that are not the only one of theirs. */
static void count_clusters(struct rmap_stats_gathered *self, const struct rmap_stats_block *block)
{
    const struct rmap_stats_setup *setup = self->setup;
    for (size_t first = 0, end = 0; first < block->n; first = end) {
        end = rmap_stats_cluster_end(block, first);
        const size_t group = rmap_stats_class(block, first) / setup->n_source;
        for (size_t i = 0; i < setup->quantities->n; i++)
            self->range[group * setup->quantities->n + i].n_cluster++;
        self->known.n_several += end - first > 1 ? end - first : 0;
    }
}

static void look(struct rmap_stats_gathered *self, const struct rmap_stats_block *block)
{
    const struct rmap_stats_setup *setup = self->setup;
    const size_t n_quantity = setup->quantities->n;
    for (size_t first = 0, end = 0; first < block->n; first = end) {
        const size_t group = rmap_stats_class(block, first) / setup->n_source;
        end = setup->n_group == 1 ? block->n : first;
        while (end < block->n && rmap_stats_class(block, end) / setup->n_source == group)
            end++;
        for (size_t i = 0; i < n_quantity; i++)
            look_at(block->value[i] + first, end - first, setup->logarithmic,
                    &self->range[group * n_quantity + i]);
    }
    count_clusters(self, block);
    self->known.n_reading += block->n;
    self->known.any_weight |= block->weight != NULL;
}

/* ---- a kind of fold ---- */

static enum rmap_status add(void *state, const struct rmap_matched *rays, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_stats_gathered *self = state;
    struct rmap_stats_block block;
    RMAP_TRY(rmap_stats_reader_read(&self->reader, self->setup, rays, &block, err));
    RMAP_TRY(keep(self, &block, err));
    self->known.n_ray += rays->n_match;
    self->known.n_undefined += self->reader.readings.n_undefined;
    look(self, &block);
out:
    return st;
}

static enum rmap_status merge(void *into, void *from, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_stats_gathered *self = into, *other = from;
    struct rmap_stats_known *known = &self->known;
    known->n_ray += other->known.n_ray;
    known->n_reading += other->known.n_reading;
    known->n_undefined += other->known.n_undefined;
    known->n_several += other->known.n_several;
    known->any_weight |= other->known.any_weight;
    for (size_t i = 0; i < n_range(self->setup); i++)
        merge_range(&self->range[i], &other->range[i]);
    if (other->known.dropped || !fits(self, other->n))
        drop(self);
    if (known->dropped || other->n_part == 0)
        return RMAP_OK;
    RMAP_TRY(RMAP_RESERVE(self->part, self->part_cap, self->n_part + other->n_part, err));
    memcpy(self->part + self->n_part, other->part, other->n_part * sizeof *self->part);
    self->n_part += other->n_part;
    self->n += other->n;
    other->n = other->n_part = 0;
out:
    return st;
}

/* Bytes: what is known, the ranges, the number of parts, and of each part a head and its data. */
struct head {
    uint64_t n, has_weight;
};

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
    const size_t range_nbytes = n_range(self->setup) * sizeof *self->range;
    const uint64_t n_part = self->n_part;
    size_t nbytes = sizeof self->known + range_nbytes + sizeof n_part;
    for (size_t p = 0; p < self->n_part; p++)
        nbytes += sizeof(struct head) +
                  part_nbytes(self->setup, self->part[p].n, self->part[p].has_weight);
    uint8_t *at = *bytes_ret = rmap_alloc_unset(nbytes, 1);
    *nbytes_ret = nbytes;
    if (!at)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu readings", self->n);
    put(&at, &self->known, sizeof self->known);
    put(&at, self->range, range_nbytes);
    put(&at, &n_part, sizeof n_part);
    for (size_t p = 0; p < self->n_part; p++) {
        const struct rmap_stats_part *part = &self->part[p];
        const struct head head = {part->n, part->has_weight};
        put(&at, &head, sizeof head);
        put(&at, part->data, part_nbytes(self->setup, part->n, part->has_weight));
    }
    return RMAP_OK;
}

/* What is left of another rank's bytes. */
struct bytes {
    const uint8_t *at;
    size_t n;
};

static enum rmap_status take(struct bytes *bytes, void *data, size_t nbytes, struct rmap_error *err)
{
    if (nbytes > bytes->n)
        return rmap_error_set(err, RMAP_INTERNAL, "another rank's readings do not fit together");
    if (nbytes > 0)
        memcpy(data, bytes->at, nbytes);
    bytes->at += nbytes;
    bytes->n -= nbytes;
    return RMAP_OK;
}

static enum rmap_status take_part(struct rmap_stats_gathered *self, struct bytes *bytes,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct head head;
    struct rmap_stats_part *part = NULL;
    RMAP_TRY(take(bytes, &head, sizeof head, err));
    if (head.n > bytes->n)
        return rmap_error_set(err, RMAP_INTERNAL, "another rank's readings do not fit together");
    RMAP_TRY(add_part(self, (size_t)head.n, head.has_weight != 0, &part, err));
    st = take(bytes, part->data, part_nbytes(self->setup, part->n, part->has_weight), err);
out:
    return st;
}

static enum rmap_status unpack(const void *context, const uint8_t *data, size_t nbytes,
                               void **state_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    void *state = NULL;
    struct bytes bytes = {data, nbytes};
    uint64_t n_part = 0;
    RMAP_TRY(create(context, &state, err));
    struct rmap_stats_gathered *self = state;
    RMAP_TRY(take(&bytes, &self->known, sizeof self->known, err));
    RMAP_TRY(take(&bytes, self->range, n_range(self->setup) * sizeof *self->range, err));
    RMAP_TRY(take(&bytes, &n_part, sizeof n_part, err));
    for (uint64_t p = 0; p < n_part; p++)
        RMAP_TRY(take_part(self, &bytes, err));
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
