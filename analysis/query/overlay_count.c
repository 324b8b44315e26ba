/* SPDX-License-Identifier: MIT
 *
 * The counts of a query whose criterion speaks of receivers: a kind of fold (fold.h).
 */
#include "analysis/query/overlay_count.h"

#include <string.h>

#include "base/alloc.h"

static void destroy(void *state)
{
    struct rmap_overlay_count *self = state;
    if (self)
        rmap_count_fini(&self->count);
    rmap_free(self);
}

static enum rmap_status create(const void *context, void **state_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_overlay_count *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a count");
    self->n_source = rmap_map_scene(context)->n_source;
    RMAP_TRY(rmap_count_init(&self->count, self->n_source, err));
    *state_ret = self;
    self = NULL;
out:
    destroy(self);
    return st;
}

static enum rmap_status add(void *state, const struct rmap_matched *rays, struct rmap_error *err)
{
    struct rmap_overlay_count *self = state;
    const struct rmap_ray_columns *ray = &rays->portion->ray;
    for (size_t i = 0; i < rays->portion->n_row[RMAP_TABLE_RAY]; i++) {
        if (rays->match && !rays->match[i])
            continue;
        if (ray->source[i] < 0 || (size_t)ray->source[i] >= self->n_source)
            return rmap_error_set(err, RMAP_FORMAT, "damaged map: a source that it has not");
        self->count.rays++;
        self->count.segments += ray->segment_count[i];
        self->count.source_weight[ray->source[i]] += ray->weight[i];
        self->count.source_weight_squared[ray->source[i]] += ray->weight[i] * ray->weight[i];
    }
    return RMAP_OK;
}

static enum rmap_status merge(void *into, void *from, struct rmap_error *err)
{
    struct rmap_overlay_count *self = into;
    const struct rmap_overlay_count *other = from;
    (void)err;
    rmap_count_add(&self->count, &other->count, self->n_source);
    return RMAP_OK;
}

static enum rmap_status pack(const void *state, uint8_t **bytes_ret, size_t *nbytes_ret,
                             struct rmap_error *err)
{
    const struct rmap_overlay_count *self = state;
    const uint64_t whole[2] = {self->count.rays, self->count.segments};
    const size_t n = self->n_source * sizeof(double);
    uint8_t *bytes = rmap_alloc(sizeof whole + 2 * n, 1);
    if (!bytes)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a count");
    memcpy(bytes, whole, sizeof whole);
    memcpy(bytes + sizeof whole, self->count.source_weight, n);
    memcpy(bytes + sizeof whole + n, self->count.source_weight_squared, n);
    *bytes_ret = bytes;
    *nbytes_ret = sizeof whole + 2 * n;
    return RMAP_OK;
}

static enum rmap_status unpack(const void *context, const uint8_t *bytes, size_t nbytes,
                               void **state_ret, struct rmap_error *err)
{
    uint64_t whole[2];
    enum rmap_status st = create(context, state_ret, err);
    if (st != RMAP_OK)
        return st;
    struct rmap_overlay_count *self = *state_ret;
    const size_t n = self->n_source * sizeof(double);
    if (nbytes != sizeof whole + 2 * n)
        return rmap_error_set(err, RMAP_INTERNAL, "a count of another length");
    memcpy(whole, bytes, sizeof whole);
    self->count.rays = whole[0];
    self->count.segments = whole[1];
    memcpy(self->count.source_weight, bytes + sizeof whole, n);
    memcpy(self->count.source_weight_squared, bytes + sizeof whole + n, n);
    return RMAP_OK;
}

const struct rmap_fold_kind rmap_overlay_count_kind = {.create = create,
                                                       .destroy = destroy,
                                                       .add = add,
                                                       .merge = merge,
                                                       .pack = pack,
                                                       .unpack = unpack};
