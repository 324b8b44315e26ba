/* SPDX-License-Identifier: MIT */
#include "analysis/stats_pack.h"

#include <string.h>

#include "base/alloc.h"

/* Bytes: what is known, the ranges, numbers of readings and parts, the parts, the values, and of
 * each part that is not plain tags and weights. */
static void put(uint8_t **at, const void *data, size_t nbytes)
{
    if (nbytes > 0)
        memcpy(*at, data, nbytes);
    *at += nbytes;
}

static size_t state_nbytes(const struct rmap_stats_gathered *self)
{
    size_t nbytes = sizeof self->known + rmap_stats_n_range(self->setup) * sizeof *self->range +
                    2 * sizeof(uint64_t) + self->n_part * sizeof *self->part +
                    self->n * self->setup->quantities->n * sizeof(double);
    for (size_t p = 0; p < self->n_part; p++)
        if (!self->part[p].is_plain)
            nbytes += self->part[p].run.end * (sizeof *self->tag + sizeof *self->weight);
    return nbytes;
}

enum rmap_status rmap_stats_gathered_pack(const void *state, uint8_t **bytes_ret,
                                          size_t *nbytes_ret, struct rmap_error *err)
{
    const struct rmap_stats_gathered *self = state;
    const uint64_t n[2] = {self->n, self->n_part};
    *nbytes_ret = state_nbytes(self);
    uint8_t *at = *bytes_ret = rmap_alloc(*nbytes_ret, 1);
    if (!at)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu readings", self->n);
    put(&at, &self->known, sizeof self->known);
    put(&at, self->range, rmap_stats_n_range(self->setup) * sizeof *self->range);
    put(&at, n, sizeof n);
    put(&at, self->part, self->n_part * sizeof *self->part);
    for (size_t i = 0; i < self->setup->quantities->n; i++)
        put(&at, self->value[i], self->n * sizeof *self->value[i]);
    for (size_t p = 0; p < self->n_part; p++) {
        const struct rmap_stats_block block = rmap_stats_gathered_block(self, p);
        if (block.tag) {
            put(&at, block.tag, block.n * sizeof *block.tag);
            put(&at, block.weight, block.n * sizeof *block.weight);
        }
    }
    return RMAP_OK;
}

static void take(const uint8_t **at, void *data, size_t nbytes)
{
    if (nbytes > 0)
        memcpy(data, *at, nbytes);
    *at += nbytes;
}

enum rmap_status rmap_stats_gathered_unpack(const void *context, const uint8_t *bytes,
                                            size_t nbytes, void **state_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    void *state = NULL;
    const uint8_t *at = bytes;
    uint64_t n[2];
    RMAP_TRY(rmap_stats_gather_kind.create(context, &state, err));
    struct rmap_stats_gathered *self = state;
    take(&at, &self->known, sizeof self->known);
    take(&at, self->range, rmap_stats_n_range(self->setup) * sizeof *self->range);
    take(&at, n, sizeof n);
    RMAP_TRY(rmap_stats_gathered_reserve(self, (size_t)n[0] + 1, (size_t)n[1] + 1, true, err));
    self->n = (size_t)n[0];
    self->n_part = (size_t)n[1];
    take(&at, self->part, self->n_part * sizeof *self->part);
    if (state_nbytes(self) != nbytes) {
        st = rmap_error_set(err, RMAP_INTERNAL, "another rank's readings do not fit together");
        goto out;
    }
    for (size_t i = 0; i < self->setup->quantities->n; i++)
        take(&at, self->value[i], self->n * sizeof *self->value[i]);
    for (size_t p = 0; p < self->n_part; p++) {
        const struct rmap_stats_part *part = &self->part[p];
        if (!part->is_plain) {
            take(&at, self->tag + part->first, part->run.end * sizeof *self->tag);
            take(&at, self->weight + part->first, part->run.end * sizeof *self->weight);
        }
    }
    *state_ret = state;
    state = NULL;
out:
    rmap_stats_gather_kind.destroy(state);
    return st;
}
