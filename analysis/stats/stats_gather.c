/* SPDX-License-Identifier: MIT */
#include "analysis/stats/stats_gather.h"

#include <math.h>
#include <string.h>

#include "analysis/stats/stats_look.h"
#include "analysis/stats/stats_pack.h"
#include "base/alloc.h"
#include "base/pick.h"

static void destroy(void *state)
{
    struct rmap_stats_gathered *self = state;
    if (!self)
        return;
    rmap_stats_reader_fini(&self->reader);
    rmap_stats_store_fini(&self->store);
    rmap_free(self->part);
    rmap_free(self->range);
    rmap_free(self);
}

static enum rmap_status create(const void *context, void **state_ret, struct rmap_error *err)
{
    const struct rmap_stats_setup *setup = context;
    struct rmap_stats_gathered *self = rmap_alloc(1, sizeof *self);
    if (self)
        self->range = rmap_alloc(rmap_stats_n_range(setup) + 1, sizeof *self->range);
    if (!self || !self->range) {
        destroy(self);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for statistics of %zu groups",
                              setup->n_group);
    }
    self->setup = setup;
    const double infinity = (double)INFINITY;
    for (size_t i = 0; i < rmap_stats_n_range(setup); i++)
        self->range[i] = (struct rmap_stats_range){
            .low = infinity, .high = -infinity, .least_positive = infinity};
    *state_ret = self;
    return RMAP_OK;
}

static void drop(struct rmap_stats_gathered *self)
{
    rmap_stats_store_fini(&self->store);
    self->n = self->n_part = 0;
    self->known.dropped = 1;
}

enum rmap_status rmap_stats_gathered_add_part(struct rmap_stats_gathered *self, size_t n,
                                              bool plain, struct rmap_stats_part **part_ret,
                                              struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    void *list = self->part, *piece;
    struct rmap_stats_part part = {.run.end = n, .is_plain = plain};
    st = rmap_reserve(&list, &self->part_cap, self->n_part + 1, sizeof *self->part, err);
    self->part = list;
    RMAP_TRY(st);
    for (size_t i = 0; i < self->setup->quantities->n; i++) {
        RMAP_TRY(rmap_stats_store_take(&self->store, n, sizeof *part.value[i], &piece, err));
        part.value[i] = piece;
        if (!plain)
            continue;
        RMAP_TRY(rmap_stats_store_take(&self->store, n, sizeof *part.place[i], &piece, err));
        part.place[i] = piece;
    }
    if (!plain) {
        RMAP_TRY(rmap_stats_store_take(&self->store, n, sizeof *part.tag, &piece, err));
        part.tag = piece;
        RMAP_TRY(rmap_stats_store_take(&self->store, n, sizeof *part.weight, &piece, err));
        part.weight = piece;
    }
    *part_ret = &self->part[self->n_part++];
    **part_ret = part;
    self->n += n;
out:
    return st;
}

/* Readings [first, end) of a block: a run of it, or all that have tags. */
static enum rmap_status keep_part(struct rmap_stats_gathered *self,
                                  const struct rmap_stats_block *block, size_t first,
                                  struct rmap_stats_run run, struct rmap_error *err)
{
    const size_t n = run.end - first;
    struct rmap_stats_part *part = NULL;
    enum rmap_status st = rmap_stats_gathered_add_part(self, n, !block->tag, &part, err);
    if (st != RMAP_OK)
        return st;
    part->run.class = run.class;
    for (size_t i = 0; i < self->setup->quantities->n; i++)
        memcpy(part->value[i], block->value[i] + first, n * sizeof *part->value[i]);
    if (block->tag)
        memcpy(part->tag, block->tag, n * sizeof *part->tag);
    for (size_t k = 0; block->tag && k < n; k++)
        part->weight[k] = block->weight ? block->weight[k] : 1.0;
    return RMAP_OK;
}

static bool fits(const struct rmap_stats_gathered *self, size_t n)
{
    /* With tags and weights or without, so that it does not matter who added first. */
    const size_t most_nbytes = sizeof(uint32_t) + (self->setup->quantities->n + 1) * sizeof(double);
    return !self->known.dropped && self->n + n <= self->setup->budget_nbytes / most_nbytes;
}

/* Lists runs whose values stand in the store already. */
static enum rmap_status list_runs(struct rmap_stats_gathered *self,
                                  const struct rmap_stats_block *block, double *const *value,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n_quantity = self->setup->quantities->n;
    uint16_t *place[RMAP_QUANTITIES_MAX] = {NULL};
    void *piece, *list = self->part;
    for (size_t i = 0; i < n_quantity; i++) {
        RMAP_TRY(rmap_stats_store_take(&self->store, block->n, sizeof *place[i], &piece, err));
        place[i] = piece;
    }
    st = rmap_reserve(&list, &self->part_cap, self->n_part + block->n_run, sizeof *self->part, err);
    self->part = list;
    RMAP_TRY(st);
    for (size_t k = 0, first = 0; k < block->n_run; first = block->run[k++].end) {
        struct rmap_stats_part *part = &self->part[self->n_part++];
        *part = (struct rmap_stats_part){.run = {block->run[k].end - first, block->run[k].class},
                                         .is_plain = true};
        for (size_t i = 0; i < n_quantity; i++) {
            part->value[i] = value[i] + first;
            part->place[i] = place[i] + first;
        }
    }
    self->n += block->n;
out:
    return st;
}

/* Keeps the block's readings, or none any more when they are too many. */
static enum rmap_status keep(struct rmap_stats_gathered *self, const struct rmap_stats_block *block,
                             struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (self->known.dropped || block->n == 0)
        return RMAP_OK;
    if (!fits(self, block->n)) {
        drop(self);
        return RMAP_OK;
    }
    if (block->tag)
        return keep_part(self, block, 0, (struct rmap_stats_run){block->n, 0}, err);
    for (size_t k = 0, first = 0; k < block->n_run; first = block->run[k++].end)
        RMAP_TRY(keep_part(self, block, first, block->run[k], err));
out:
    return st;
}

/* Memory of the store for n readings of each quantity. */
static enum rmap_status take_columns(struct rmap_stats_gathered *self, size_t n, double **column,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < self->setup->quantities->n; i++) {
        void *piece;
        RMAP_TRY(rmap_stats_store_take(&self->store, n, sizeof *column[i], &piece, err));
        column[i] = piece;
    }
out:
    return st;
}

/* A portion of which all rays are expected to match, and are of one source. */
static enum rmap_status lend(void *state, const struct rmap_portion_info *portion,
                             struct rmap_fold_loan *loan, struct rmap_error *err)
{
    struct rmap_stats_gathered *self = state;
    struct rmap_stats_lent *lent = &self->lent;
    enum rmap_status st = RMAP_OK;
    const size_t n_ray = (size_t)portion->n_row[RMAP_TABLE_RAY];
    if (lent->is_lent) /* of a portion without a match */
        rmap_stats_store_give_back(&self->store, &lent->before);
    lent->is_lent = false;
    if (!rmap_quantities_columns(self->setup->quantities, loan->column))
        return RMAP_OK;
    loan->n = self->setup->quantities->n;
    if (!lent->is_promising || !fits(self, n_ray) ||
        rmap_stats_told_source(self->setup, portion) < 0)
        return RMAP_OK;
    lent->before = self->store;
    RMAP_TRY(take_columns(self, n_ray, lent->column, err));
    lent->is_lent = true;
    for (size_t i = 0; i < loan->n; i++)
        loan->memory[i] = lent->column[i];
out:
    return st;
}

/* How many of the block's quantities stand there. */
static size_t n_standing(const struct rmap_stats_gathered *self,
                         const struct rmap_stats_block *block, double *const *column)
{
    size_t n = 0;
    for (size_t i = 0; i < self->setup->quantities->n; i++)
        n += block->value[i] == column[i];
    return n;
}

/* Keeps the block, its values where they are if that is the memory that was lent. */
static enum rmap_status keep_lent(struct rmap_stats_gathered *self,
                                  const struct rmap_stats_block *block, struct rmap_error *err)
{
    const size_t n = n_standing(self, block, self->lent.column);
    if (n == self->setup->quantities->n && !block->tag)
        return list_runs(self, block, self->lent.column, err);
    if (n == 0)
        rmap_stats_store_give_back(&self->store, &self->lent.before);
    return keep(self, block, err);
}

/* Reads a portion, its values into the store where that saves copying them. */
static enum rmap_status read_and_keep(struct rmap_stats_gathered *self,
                                      const struct rmap_matched *rays,
                                      struct rmap_stats_block *block, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_stats_store before = self->store;
    const bool is_lent = self->lent.is_lent;
    double **into = self->reader.into;
    self->lent.is_lent = false;
    if (!is_lent && fits(self, rays->n_match))
        RMAP_TRY(take_columns(self, rays->n_match + RMAP_PICK_MORE, into, err));
    RMAP_TRY(rmap_stats_reader_read(&self->reader, self->setup, rays, block, err));
    self->lent.is_promising =
        !block->tag && block->n_run == 1 && block->n == rays->portion->n_row[RMAP_TABLE_RAY];
    if (is_lent) {
        st = keep_lent(self, block, err);
    } else if (into[0] && block->value[0] == into[0]) {
        st = list_runs(self, block, into, err);
    } else {
        rmap_stats_store_give_back(&self->store, &before);
        st = keep(self, block, err);
    }
out:
    memset(self->reader.into, 0, sizeof self->reader.into);
    return st;
}

static enum rmap_status add(void *state, const struct rmap_matched *rays, struct rmap_error *err)
{
    struct rmap_stats_gathered *self = state;
    struct rmap_stats_block block;
    enum rmap_status st = read_and_keep(self, rays, &block, err);
    if (st != RMAP_OK)
        return st;
    self->known.n_ray += rays->n_match;
    self->known.n_undefined += self->reader.readings.n_undefined;
    rmap_stats_look(self, &block);
    return RMAP_OK;
}

struct rmap_stats_block rmap_stats_gathered_block(const struct rmap_stats_gathered *self,
                                                  size_t index)
{
    const struct rmap_stats_part *part = &self->part[index];
    struct rmap_stats_block block = {.n = part->run.end,
                                     .tag = part->tag,
                                     .weight = part->weight,
                                     .run = part->is_plain ? &part->run : NULL,
                                     .n_run = part->is_plain};
    for (size_t i = 0; i < self->setup->quantities->n; i++) {
        block.value[i] = part->value[i];
        block.place[i] = part->place[i];
        block.next[i] = index + 1 < self->n_part ? part[1].value[i] : NULL;
    }
    return block;
}

/* But for the readings. */
static void merge_known(struct rmap_stats_gathered *self, const struct rmap_stats_gathered *other)
{
    struct rmap_stats_known *known = &self->known;
    known->n_ray += other->known.n_ray;
    known->n_reading += other->known.n_reading;
    known->n_undefined += other->known.n_undefined;
    known->n_several += other->known.n_several;
    known->any_weight |= other->known.any_weight;
    for (size_t i = 0; i < rmap_stats_n_range(self->setup); i++)
        rmap_stats_range_merge(&self->range[i], &other->range[i]);
    if (other->known.dropped && !known->dropped)
        drop(self);
}

static enum rmap_status merge(void *into, const void *from, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_stats_gathered *self = into;
    const struct rmap_stats_gathered *other = from;
    merge_known(self, other);
    for (size_t p = 0; p < other->n_part && st == RMAP_OK; p++) {
        const struct rmap_stats_block block = rmap_stats_gathered_block(other, p);
        st = keep(self, &block, err);
    }
    return st;
}

/* Readings stay where they are, and change hands. */
static enum rmap_status absorb(void *into, void *from, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_stats_gathered *self = into, *other = from;
    void *list = self->part;
    merge_known(self, other);
    if (self->known.dropped || other->n_part == 0)
        return RMAP_OK;
    if (!fits(self, other->n)) {
        drop(self);
        return RMAP_OK;
    }
    st =
        rmap_reserve(&list, &self->part_cap, self->n_part + other->n_part, sizeof *self->part, err);
    self->part = list;
    RMAP_TRY(st);
    RMAP_TRY(rmap_stats_store_absorb(&self->store, &other->store, err));
    memcpy(self->part + self->n_part, other->part, other->n_part * sizeof *self->part);
    self->n_part += other->n_part;
    self->n += other->n;
    other->n = other->n_part = 0;
out:
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
                                                      .absorb = absorb,
                                                      .lend = lend,
                                                      .pack = rmap_stats_gathered_pack,
                                                      .unpack = rmap_stats_gathered_unpack,
                                                      .may_count = may_count};
