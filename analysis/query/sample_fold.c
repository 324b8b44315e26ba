/* SPDX-License-Identifier: MIT
 *
 * The ids of some of the matching rays as a fold (fold.h), so that receivers may decide what
 * matches.
 */
#include "analysis/query/sample_fold.h"

#include <string.h>

#include "analysis/query/quantity_read.h"
#include "base/alloc.h"

static const uint64_t sign = (uint64_t)1 << 63;

/* Bits of doubles order as numbers do, those of negative ones the other way round. */
uint64_t rmap_sample_key_of_value(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits & sign ? bits : ~(bits | sign);
}

double rmap_sample_value_of_key(uint64_t key)
{
    const uint64_t bits = key & sign ? key : ~key ^ sign;
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static void destroy(void *state)
{
    struct rmap_sample_fold *self = state;
    if (!self)
        return;
    rmap_sample_fini(&self->sample);
    rmap_readings_fini(&self->readings);
    rmap_free(self);
}

static enum rmap_status create(const void *context, void **state_ret, struct rmap_error *err)
{
    const struct rmap_sample_order *order = context;
    struct rmap_sample_fold *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the sample");
    *self = (struct rmap_sample_fold){.order = order, .sample = {.most = order->most}};
    *state_ret = self;
    return RMAP_OK;
}

static enum rmap_status add_one(struct rmap_sample_fold *self, struct rmap_sample_ray ray,
                                struct rmap_error *err)
{
    if (self->order->or_none && self->sample.n == self->order->most)
        return rmap_error_set(err, RMAP_SYSTEM,
                              "more than %llu rays match: with --receivers their ids are kept in "
                              "memory; ask for some of them, by --limit or --sample",
                              (unsigned long long)self->order->most);
    return rmap_sample_add(&self->sample, ray, err);
}

/* Each ray by the greatest of its readings, which lie together. */
static enum rmap_status add_values(struct rmap_sample_fold *self, const struct rmap_matched *rays,
                                   struct rmap_error *err)
{
    const struct rmap_readings *readings = &self->readings;
    enum rmap_status st = rmap_quantities_read(self->order->of, rays, &self->readings, err);
    for (size_t k = 0; st == RMAP_OK && k < readings->n;) {
        const uint32_t row = readings->ray[k];
        double value = readings->value[0][k];
        while (++k < readings->n && readings->ray[k] == row)
            if (readings->value[0][k] > value)
                value = readings->value[0][k];
        st = add_one(
            self,
            (struct rmap_sample_ray){rmap_sample_key_of_value(value), rays->portion->ray.id[row]},
            err);
    }
    return st;
}

/* Of rays whose greatest possible value is less than all that are kept, none is looked at. */
static enum rmap_status narrow(void *state, const struct rmap_matched *rays, uint8_t *match,
                               struct rmap_error *err)
{
    const struct rmap_sample_fold *self = state;
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_sum none = {0}, *of_path, *own;
    struct rmap_path_summary paths;
    double bound[2];
    if (!self->order->of || self->sample.n < self->sample.most ||
        !rmap_quantity_bound(self->order->of, 0, &none, bound))
        return RMAP_OK;
    RMAP_TRY(rmap_fold_path_bounds(rays, &paths, &of_path, &own, err));
    const double worst = rmap_sample_value_of_key(self->sample.ray[0].key);
    const size_t n =
        (size_t)rmap_map_portion(self->order->of->map, rays->index)->n_row[RMAP_TABLE_RAY];
    for (size_t i = 0, k = 0; paths.paths && i < n; i++) {
        const uint32_t path = paths.path[i];
        const size_t at = path > 0 ? path - 1 : k++;
        const struct rmap_path_sum *its = path > 0 ? of_path : own;
        its = its ? its + at : NULL;
        if (match[i] && its && rmap_quantity_bound(self->order->of, 0, its, bound) &&
            bound[1] < worst)
            match[i] = 0;
    }
out:
    return st;
}

static enum rmap_status add(void *state, const struct rmap_matched *rays, struct rmap_error *err)
{
    struct rmap_sample_fold *self = state;
    const struct rmap_portion *portion = rays->portion;
    enum rmap_status st = RMAP_OK;
    if (self->order->of)
        return add_values(self, rays, err);
    for (size_t i = 0; st == RMAP_OK && i < portion->n_row[RMAP_TABLE_RAY]; i++)
        if (!rays->match || rays->match[i])
            st = add_one(self, rmap_sample_ray_of(self->order, portion->ray.id[i]), err);
    return st;
}

static enum rmap_status add_all(struct rmap_sample_fold *self, const uint8_t *bytes, size_t n,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < n && st == RMAP_OK; i++) {
        struct rmap_sample_ray ray;
        memcpy(&ray, bytes + i * sizeof ray, sizeof ray);
        st = add_one(self, ray, err);
    }
    return st;
}

static enum rmap_status merge(void *into, void *from, struct rmap_error *err)
{
    const struct rmap_sample *more = &((const struct rmap_sample_fold *)from)->sample;
    return add_all(into, (const uint8_t *)more->ray, more->n, err);
}

static enum rmap_status pack(const void *state, uint8_t **bytes_ret, size_t *nbytes_ret,
                             struct rmap_error *err)
{
    const struct rmap_sample *sample = &((const struct rmap_sample_fold *)state)->sample;
    const size_t nbytes = sample->n * sizeof *sample->ray;
    uint8_t *bytes = rmap_alloc(nbytes + 1, 1);
    if (!bytes)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the sample");
    if (nbytes > 0)
        memcpy(bytes, sample->ray, nbytes);
    *bytes_ret = bytes;
    *nbytes_ret = nbytes;
    return RMAP_OK;
}

static enum rmap_status unpack(const void *context, const uint8_t *bytes, size_t nbytes,
                               void **state_ret, struct rmap_error *err)
{
    enum rmap_status st = create(context, state_ret, err);
    if (st == RMAP_OK)
        st = add_all(*state_ret, bytes, nbytes / sizeof(struct rmap_sample_ray), err);
    return st;
}

const struct rmap_fold_kind rmap_sample_kind = {.create = create,
                                                .destroy = destroy,
                                                .add = add,
                                                .narrow = narrow,
                                                .merge = merge,
                                                .pack = pack,
                                                .unpack = unpack};
