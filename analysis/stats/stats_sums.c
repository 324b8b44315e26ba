/* SPDX-License-Identifier: MIT */
#include "analysis/stats/stats_sums.h"

#include <stdlib.h>
#include <string.h>

#include "analysis/stats/stats_ones.h"
#include "analysis/stats/stats_places.h"
#include "base/alloc.h"

/* A reading of a cluster in its cell. */
struct rmap_stats_place {
    size_t cell;
    double weight;
};

/* The arrays that are merged and sent. */
struct extent {
    size_t moments, cell, single, fine; /* elements */
};

static struct extent extent_of(const struct rmap_stats_plan *plan)
{
    const struct rmap_stats_setup *setup = plan->setup;
    const size_t n_moments = setup->n_class * setup->quantities->n;
    const size_t n_cell = setup->n_class * (plan->n_cell + RMAP_STATS_BEYOND);
    return (struct extent){n_moments, n_cell, n_cell, n_moments * plan->n_fine};
}

double rmap_stats_sums_nbytes(const struct rmap_stats_setup *setup, double n_cell, double n_fine)
{
    const double n_class = (double)setup->n_class, n_quantity = (double)setup->quantities->n;
    return n_class *
           (n_quantity *
                (sizeof(struct rmap_stats_moments) + n_fine * (sizeof(double) + sizeof(uint32_t))) +
            (n_cell + RMAP_STATS_BEYOND) * (sizeof(struct rmap_stats_cell) + sizeof(double)));
}

static void destroy(void *state)
{
    struct rmap_stats_sums *self = state;
    if (!self)
        return;
    rmap_stats_reader_fini(&self->reader);
    rmap_free(self->moments);
    rmap_free(self->cell);
    rmap_free(self->single);
    rmap_free(self->fine);
    rmap_free(self->fine_single);
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
        self->single = rmap_alloc(extent.single, sizeof *self->single);
        self->fine_single = rmap_alloc(extent.fine, sizeof *self->fine_single);
    }
    if (!self || !self->moments || !self->cell || !self->single || !self->fine_single) {
        destroy(self);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a histogram of %zu bins",
                              plan->n_cell);
    }
    *state_ret = self;
    return RMAP_OK;
}

/* Memory for the weights of fine bins, where any are. */
static enum rmap_status hold_fine(struct rmap_stats_sums *self, struct rmap_error *err)
{
    const size_t n = extent_of(self->plan).fine;
    if (!self->fine)
        self->fine = rmap_alloc(n, sizeof *self->fine);
    if (self->fine)
        return RMAP_OK;
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu bins", n);
}

/* Makes room in the counts of fine bins for n more in any of them. */
static enum rmap_status make_room(struct rmap_stats_sums *self, uint64_t n, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n_bin = extent_of(self->plan).fine;
    if (self->n_single + n > UINT32_MAX) {
        RMAP_TRY(hold_fine(self, err));
        for (size_t i = 0; i < n_bin; i++)
            self->fine[i] += self->fine_single[i];
        memset(self->fine_single, 0, n_bin * sizeof *self->fine_single);
        self->n_single = 0;
    }
    self->n_single += n;
out:
    return st;
}

static int compare_places(const void *a, const void *b)
{
    size_t x = ((const struct rmap_stats_place *)a)->cell;
    size_t y = ((const struct rmap_stats_place *)b)->cell;
    return (x > y) - (x < y);
}

/* What a cluster [first, end) adds to cells: its readings in one cell go together. */
static enum rmap_status add_to_cells(struct rmap_stats_sums *self,
                                     const struct rmap_stats_block *block, size_t first, size_t end,
                                     struct rmap_stats_cell *cell, struct rmap_error *err)
{
    const size_t n = end - first;
    void *memory = self->place;
    enum rmap_status st = rmap_reserve(&memory, &self->place_cap, n, sizeof *self->place, err);
    struct rmap_stats_place *place = self->place = memory;
    if (st != RMAP_OK)
        return st;
    for (size_t k = 0; k < n; k++)
        place[k] = (struct rmap_stats_place){rmap_stats_cell_of(self->plan, block, first + k),
                                             rmap_stats_weight(block, first + k)};
    qsort(place, n, sizeof *place, compare_places);
    for (size_t k = 0; k < n;) {
        struct rmap_stats_cell *its = &cell[place[k].cell];
        double weight = 0.0;
        for (size_t same = place[k].cell; k < n && place[k].cell == same; k++)
            weight += place[k].weight;
        its->rays += 1.0;
        its->weight += weight;
        its->squared += rmap_stats_rounded(weight * weight);
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

static enum rmap_status add_cluster(struct rmap_stats_sums *self,
                                    const struct rmap_stats_block *block, size_t first, size_t end,
                                    struct rmap_error *err)
{
    const struct rmap_stats_plan *plan = self->plan;
    const size_t n_quantity = plan->setup->quantities->n;
    const size_t class = rmap_stats_class(block->tag[first]);
    enum rmap_status st = hold_fine(self, err);
    if (st != RMAP_OK)
        return st;
    double *fine = self->fine + class * n_quantity * plan->n_fine;
    for (size_t i = 0; i < n_quantity; i++, fine += plan->n_fine) {
        add_to_moments(plan, block, i, first, end, &self->moments[class * n_quantity + i]);
        for (size_t k = first; k < end; k++)
            fine[rmap_stats_fine(plan, i, block->value[i][k])] += rmap_stats_weight(block, k);
    }
    return add_to_cells(self, block, first, end,
                        self->cell + class * (plan->n_cell + RMAP_STATS_BEYOND), err);
}

static enum rmap_status add_portion(struct rmap_stats_sums *self,
                                    const struct rmap_stats_block *block, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t last = block->n;
    const size_t n_moments = self->plan->setup->n_class * self->plan->setup->quantities->n;
    for (size_t first = 0, end = 0; first < last; first = end) {
        const struct rmap_stats_ones ones = rmap_stats_ones_at(block, first, last);
        end = first + ones.n;
        if (ones.n > 0) {
            rmap_stats_sums_add_ones(self, block, &ones);
            continue;
        }
        end = rmap_stats_cluster_end(block, first);
        RMAP_TRY(add_cluster(self, block, first, end, err));
    }
    for (size_t i = 0; i < n_moments; i++)
        rmap_stats_moments_flush(&self->moments[i]);
out:
    return st;
}

/* Readings by class, each a cluster of its own and of weight 1. */
static void add_plain(struct rmap_stats_sums *self, const struct rmap_stats_block *block)
{
    const size_t n_quantity = self->plan->setup->quantities->n;
    for (size_t r = 0, first = 0; r < block->n_run; r++) {
        const size_t end = block->run[r].end;
        for (size_t n; first < end; first += n) {
            n = end - first < RMAP_STATS_ONES_MOST ? end - first : RMAP_STATS_ONES_MOST;
            struct rmap_stats_ones ones = {
                .class = block->run[r].class, .first = first, .n = n, .are_last = first + n == end};
            for (size_t i = 0; i < n_quantity; i++)
                ones.next[i] = first + n < block->n ? block->value[i] + first + n : block->next[i];
            rmap_stats_sums_add_ones(self, block, &ones);
        }
    }
}

enum rmap_status rmap_stats_sums_add(struct rmap_stats_sums *self,
                                     const struct rmap_stats_block *block, struct rmap_error *err)
{
    enum rmap_status st = make_room(self, block->n, err);
    if (st == RMAP_OK && block->tag)
        return add_portion(self, block, err);
    if (st == RMAP_OK)
        add_plain(self, block);
    return st;
}

void rmap_stats_sums_finish(struct rmap_stats_sums *self)
{
    const struct rmap_stats_plan *plan = self->plan;
    const size_t n_cell = plan->n_cell + RMAP_STATS_BEYOND;
    for (size_t class = 0; plan->n_fine_per_cell > 0 && class < plan->setup->n_class; class ++)
        rmap_stats_cells_from_fine(plan, self->fine_single + class * plan->n_fine,
                                   self->single + class * n_cell);
}

static enum rmap_status add(void *state, const struct rmap_matched *rays, struct rmap_error *err)
{
    struct rmap_stats_sums *self = state;
    struct rmap_stats_block block;
    enum rmap_status st =
        rmap_stats_reader_read(&self->reader, self->plan->setup, rays, &block, err);
    return st == RMAP_OK ? rmap_stats_sums_add(self, &block, err) : st;
}

static enum rmap_status merge(void *into, const void *from, struct rmap_error *err)
{
    struct rmap_stats_sums *self = into;
    const struct rmap_stats_sums *other = from;
    const struct extent extent = extent_of(self->plan);
    enum rmap_status st = make_room(self, other->n_single, err);
    if (st == RMAP_OK && other->fine)
        st = hold_fine(self, err);
    if (st != RMAP_OK)
        return st;
    for (size_t i = 0; i < extent.moments; i++)
        rmap_stats_moments_merge(&self->moments[i], &other->moments[i]);
    for (size_t i = 0; i < extent.cell; i++) {
        self->cell[i].rays += other->cell[i].rays;
        self->cell[i].weight += other->cell[i].weight;
        self->cell[i].squared += other->cell[i].squared;
    }
    for (size_t i = 0; i < extent.single; i++)
        self->single[i] += other->single[i];
    for (size_t i = 0; i < extent.fine; i++)
        self->fine_single[i] += other->fine_single[i];
    for (size_t i = 0; other->fine && i < extent.fine; i++)
        self->fine[i] += other->fine[i];
    return RMAP_OK;
}

/* Copies every array to bytes, or from them; returns how many bytes they are. */
static size_t copy(struct rmap_stats_sums *self, uint8_t *to, const uint8_t *from)
{
    const struct extent extent = extent_of(self->plan);
    const struct {
        void *data;
        size_t nbytes;
    } array[] = {
        {self->moments, extent.moments * sizeof *self->moments},
        {self->cell, extent.cell * sizeof *self->cell},
        {self->single, extent.single * sizeof *self->single},
        {self->fine_single, extent.fine * sizeof *self->fine_single},
        {self->fine, self->fine ? extent.fine * sizeof *self->fine : 0},
    };
    size_t at = 0;
    for (size_t i = 0; i < sizeof array / sizeof *array; at += array[i++].nbytes) {
        if (to && array[i].nbytes > 0)
            memcpy(to + at, array[i].data, array[i].nbytes);
        if (from && array[i].nbytes > 0)
            memcpy(array[i].data, from + at, array[i].nbytes);
    }
    return at;
}

/* Ahead of the arrays. */
struct head {
    uint64_t n_single, has_fine;
};

static enum rmap_status pack(const void *state, uint8_t **bytes_ret, size_t *nbytes_ret,
                             struct rmap_error *err)
{
    struct rmap_stats_sums self = *(const struct rmap_stats_sums *)state;
    const struct head head = {self.n_single, self.fine != NULL};
    *nbytes_ret = sizeof head + copy(&self, NULL, NULL);
    *bytes_ret = rmap_alloc(*nbytes_ret, 1);
    if (!*bytes_ret)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a histogram's sums");
    memcpy(*bytes_ret, &head, sizeof head);
    (void)copy(&self, *bytes_ret + sizeof head, NULL);
    return RMAP_OK;
}

static enum rmap_status unpack(const void *context, const uint8_t *bytes, size_t nbytes,
                               void **state_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    void *state = NULL;
    struct head head = {0, 0};
    RMAP_TRY(create(context, &state, err));
    struct rmap_stats_sums *self = state;
    if (nbytes >= sizeof head)
        memcpy(&head, bytes, sizeof head);
    if (head.has_fine)
        RMAP_TRY(hold_fine(self, err));
    self->n_single = head.n_single;
    if (sizeof head + copy(self, NULL, NULL) != nbytes) {
        st = rmap_error_set(err, RMAP_INTERNAL, "another rank's sums do not fit together");
        goto out;
    }
    (void)copy(self, NULL, bytes + sizeof head);
    *state_ret = state;
    state = NULL;
out:
    destroy(state);
    return st;
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
                                                    .pack = pack,
                                                    .unpack = unpack,
                                                    .may_count = may_count};
