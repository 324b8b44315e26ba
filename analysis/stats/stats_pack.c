/* SPDX-License-Identifier: MIT */
#include "analysis/stats/stats_pack.h"

#include <string.h>

#include "base/alloc.h"

/* Bytes: what is known, the ranges, the number of parts, and of each part a head, its values, and
 * unless it is plain tags and weights. */
struct head {
    uint64_t n, class, is_plain;
};

static void put(uint8_t **at, const void *data, size_t nbytes)
{
    if (nbytes > 0)
        memcpy(*at, data, nbytes);
    *at += nbytes;
}

static size_t part_nbytes(const struct rmap_stats_setup *setup, uint64_t n, bool plain)
{
    const size_t tag = sizeof(uint32_t) + sizeof(double);
    return (size_t)n * (setup->quantities->n * sizeof(double) + (plain ? 0 : tag));
}

enum rmap_status rmap_stats_gathered_pack(const void *state, uint8_t **bytes_ret,
                                          size_t *nbytes_ret, struct rmap_error *err)
{
    const struct rmap_stats_gathered *self = state;
    const size_t range_nbytes = rmap_stats_n_range(self->setup) * sizeof *self->range;
    const uint64_t n_part = self->n_part;
    *nbytes_ret = sizeof self->known + range_nbytes + sizeof n_part;
    for (size_t p = 0; p < self->n_part; p++)
        *nbytes_ret += sizeof(struct head) +
                       part_nbytes(self->setup, self->part[p].run.end, self->part[p].is_plain);
    uint8_t *at = *bytes_ret = rmap_alloc(*nbytes_ret, 1);
    if (!at)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu readings", self->n);
    put(&at, &self->known, sizeof self->known);
    put(&at, self->range, range_nbytes);
    put(&at, &n_part, sizeof n_part);
    for (size_t p = 0; p < self->n_part; p++) {
        const struct rmap_stats_part *part = &self->part[p];
        const struct head head = {part->run.end, part->run.class, part->is_plain};
        put(&at, &head, sizeof head);
        for (size_t i = 0; i < self->setup->quantities->n; i++)
            put(&at, part->value[i], part->run.end * sizeof *part->value[i]);
        if (part->is_plain)
            continue;
        put(&at, part->tag, part->run.end * sizeof *part->tag);
        put(&at, part->weight, part->run.end * sizeof *part->weight);
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
    if (head.n > bytes->n || head.class >= self->setup->n_class)
        return rmap_error_set(err, RMAP_INTERNAL, "another rank's readings do not fit together");
    RMAP_TRY(rmap_stats_gathered_add_part(self, (size_t)head.n, head.is_plain != 0, &part, err));
    part->run.class = (size_t)head.class;
    for (size_t i = 0; i < self->setup->quantities->n; i++)
        RMAP_TRY(take(bytes, part->value[i], part->run.end * sizeof *part->value[i], err));
    if (part->is_plain)
        return RMAP_OK;
    RMAP_TRY(take(bytes, part->tag, part->run.end * sizeof *part->tag, err));
    st = take(bytes, part->weight, part->run.end * sizeof *part->weight, err);
out:
    return st;
}

enum rmap_status rmap_stats_gathered_unpack(const void *context, const uint8_t *data, size_t nbytes,
                                            void **state_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    void *state = NULL;
    struct bytes bytes = {data, nbytes};
    uint64_t n_part = 0;
    RMAP_TRY(rmap_stats_gather_kind.create(context, &state, err));
    struct rmap_stats_gathered *self = state;
    RMAP_TRY(take(&bytes, &self->known, sizeof self->known, err));
    RMAP_TRY(take(&bytes, self->range, rmap_stats_n_range(self->setup) * sizeof *self->range, err));
    RMAP_TRY(take(&bytes, &n_part, sizeof n_part, err));
    for (uint64_t p = 0; p < n_part; p++)
        RMAP_TRY(take_part(self, &bytes, err));
    *state_ret = state;
    state = NULL;
out:
    rmap_stats_gather_kind.destroy(state);
    return st;
}
