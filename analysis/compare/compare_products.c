/* SPDX-License-Identifier: MIT */
#include "analysis/compare/compare_products.h"

#include <string.h>

#include "analysis/compare/compare_internal.h"
#include "base/alloc.h"

/* 32 Mi numbers: a quarter of a GiB for each thread. */
static const size_t VALUE_MAX = (size_t)32 << 20;

enum rmap_status rmap_compare_products_layout_init(struct rmap_compare_products_layout *layout,
                                                   const struct rmap_compare_layout *of,
                                                   const struct rmap_comparison *comparison,
                                                   int which, struct rmap_error *err)
{
    *layout = (struct rmap_compare_products_layout){.of = of};
    layout->group = rmap_alloc(of->n_detector + 1, sizeof *layout->group);
    layout->n_group = rmap_alloc(of->n_detector + 1, sizeof *layout->n_group);
    layout->first = rmap_alloc(of->n_detector + 1, sizeof *layout->first);
    if (!layout->group || !layout->n_group || !layout->first) {
        rmap_compare_products_layout_fini(layout);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu detectors", of->n_detector);
    }
    for (size_t i = 0; i < comparison->n_again; i++) {
        const struct rmap_compare_again *again = &comparison->again[i];
        layout->group[again->detector[which]] = again->group;
        layout->n_group[again->detector[which]] = again->n_group;
    }
    for (size_t d = 0; d < of->n_detector; d++) {
        size_t n = layout->n_group[d];
        layout->first[d + 1] = layout->first[d] + n + n * (n + 1) / 2;
    }
    layout->n_value = layout->first[of->n_detector];
    if (layout->n_value <= VALUE_MAX / (of->n_source > 0 ? of->n_source : 1))
        return RMAP_OK;
    rmap_compare_products_layout_fini(layout);
    return rmap_error_set(err, RMAP_SYSTEM,
                          "the images of so many detectors, of %zu sources, are too many to "
                          "compare at once; name one with --detector",
                          of->n_source);
}

void rmap_compare_products_layout_fini(struct rmap_compare_products_layout *layout)
{
    rmap_free(layout->group);
    rmap_free(layout->n_group);
    rmap_free(layout->first);
    *layout = (struct rmap_compare_products_layout){0};
}

static size_t n_value(const struct rmap_compare_products_layout *layout)
{
    return layout->of->n_source * layout->n_value;
}

static void destroy(void *state)
{
    struct rmap_compare_products *self = state;
    if (!self)
        return;
    rmap_free(self->value);
    rmap_free(self->own);
    rmap_free(self->met);
    rmap_free(self);
}

static enum rmap_status create(const void *context, void **state_ret, struct rmap_error *err)
{
    const struct rmap_compare_products_layout *layout = context;
    struct rmap_compare_products *self = rmap_alloc(1, sizeof *self);
    size_t most = 0;
    for (size_t d = 0; d < layout->of->n_detector; d++)
        most = layout->n_group[d] > most ? layout->n_group[d] : most;
    if (self) {
        self->layout = layout;
        self->value = rmap_alloc(n_value(layout) + 1, sizeof *self->value);
        self->own = rmap_alloc(most + 1, sizeof *self->own);
        self->met = rmap_alloc(most + 1, sizeof *self->met);
    }
    if (!self || !self->value || !self->own || !self->met) {
        destroy(self);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu sums", n_value(layout));
    }
    *state_ret = self;
    return RMAP_OK;
}

/* Rows [first, end) of /registration are of one ray: what it adds to the groups of detector d. */
static size_t gather(struct rmap_compare_products *self, const struct rmap_matched *rays,
                     size_t first, size_t end, size_t d, double weight)
{
    const struct rmap_registration_columns *at = &rays->portion->registration;
    const uint8_t *counts = rmap_registrations_counted(rays);
    const uint32_t width = self->layout->of->scene->detector[d].cells[0];
    size_t n_met = 0;
    for (size_t row = first; row < end; row++) {
        if (!counts[row] || (size_t)at->detector[row] != d)
            continue;
        int32_t group =
            self->layout->group[d][at->cell[2 * row] + (size_t)at->cell[2 * row + 1] * width];
        if (group < 0)
            continue;
        if (self->own[group] == 0.0)
            self->met[n_met++] = (size_t)group;
        self->own[group] += weight;
    }
    return n_met;
}

static void add_products(struct rmap_compare_products *self, size_t source, size_t d, size_t n_met)
{
    const struct rmap_compare_products_layout *layout = self->layout;
    double *sum = self->value + source * layout->n_value + layout->first[d];
    double *product = sum + layout->n_group[d];
    for (size_t i = 0; i < n_met; i++) {
        size_t a = self->met[i];
        sum[a] += self->own[a];
        for (size_t j = 0; j < n_met; j++)
            if (self->met[j] <= a)
                product[a * (a + 1) / 2 + self->met[j]] += self->own[a] * self->own[self->met[j]];
    }
    for (size_t i = 0; i < n_met; i++)
        self->own[self->met[i]] = 0.0;
}

/* The first pass has checked the cells. */
static enum rmap_status add(void *state, const struct rmap_matched *rays, struct rmap_error *err)
{
    struct rmap_compare_products *self = state;
    const struct rmap_portion *portion = rays->portion;
    size_t row = 0;
    (void)err;
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_RAY]; i++) {
        size_t end = row + portion->ray.registration_count[i];
        if (!rays->match || rays->match[i])
            for (size_t at = row; at < end; at++) {
                size_t d = (size_t)portion->registration.detector[at];
                bool seen = !self->layout->group[d];
                for (size_t before = row; before < at && !seen; before++)
                    seen = (size_t)portion->registration.detector[before] == d;
                if (!seen)
                    add_products(self, (size_t)portion->ray.source[i], d,
                                 gather(self, rays, row, end, d, portion->ray.weight[i]));
            }
        row = end;
    }
    return RMAP_OK;
}

static enum rmap_status merge(void *into, void *from, struct rmap_error *err)
{
    struct rmap_compare_products *self = into;
    const struct rmap_compare_products *other = from;
    (void)err;
    for (size_t i = 0; i < n_value(self->layout); i++)
        self->value[i] += other->value[i];
    return RMAP_OK;
}

static enum rmap_status pack(const void *state, uint8_t **bytes_ret, size_t *nbytes_ret,
                             struct rmap_error *err)
{
    const struct rmap_compare_products *self = state;
    return rmap_compare_pack(self->value, n_value(self->layout), bytes_ret, nbytes_ret, err);
}

static enum rmap_status unpack(const void *context, const uint8_t *bytes, size_t nbytes,
                               void **state_ret, struct rmap_error *err)
{
    const struct rmap_compare_products_layout *layout = context;
    if (nbytes != n_value(layout) * sizeof(double))
        return rmap_error_set(err, RMAP_INTERNAL, "sums of another rank have %zu bytes", nbytes);
    enum rmap_status st = create(context, state_ret, err);
    if (st == RMAP_OK)
        memcpy(((struct rmap_compare_products *)*state_ret)->value, bytes, nbytes);
    return st;
}

const struct rmap_fold_kind rmap_compare_products_kind = {.create = create,
                                                          .destroy = destroy,
                                                          .add = add,
                                                          .merge = merge,
                                                          .pack = pack,
                                                          .unpack = unpack};

enum rmap_status rmap_comparison_add_products(struct rmap_comparison *comparison,
                                              const struct rmap_compare_sums *both,
                                              const struct rmap_compare_products *const products[2],
                                              struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n = comparison->strata.n;
    const double **sum[2] = {rmap_alloc(n + 1, sizeof **sum), rmap_alloc(n + 1, sizeof **sum)};
    const double **product[2] = {rmap_alloc(n + 1, sizeof **sum), rmap_alloc(n + 1, sizeof **sum)};
    if (!sum[0] || !sum[1] || !product[0] || !product[1]) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu sources", n);
        goto out;
    }
    for (size_t i = 0; i < comparison->n_again; i++) {
        const struct rmap_compare_again *again = &comparison->again[i];
        struct rmap_chi_square result;
        for (size_t s = 0; s < n; s++)
            for (int k = 0; k < 2; k++) {
                const struct rmap_compare_products_layout *layout = products[k]->layout;
                int32_t source = comparison->strata.stratum[s].source[k];
                sum[k][s] = source < 0 ? NULL
                                       : products[k]->value + (size_t)source * layout->n_value +
                                             layout->first[again->detector[k]];
                product[k][s] = sum[k][s] ? sum[k][s] + again->n_group : NULL;
            }
        const struct rmap_products matrix = {.n_group = again->n_group,
                                             .count = {sum[0], sum[1]},
                                             .product = {product[0], product[1]}};
        RMAP_TRY(rmap_difference_products(&comparison->strata, &matrix, &result, err));
        rmap_compare_count_both(both, again->detector[0], &result);
        RMAP_TRY(rmap_comparison_add_bins(
            comparison, RMAP_COMPARE_IMAGE,
            rmap_comparison_scene(comparison, 0)->detector[again->detector[0]].name, &result, NULL,
            err));
    }
out:
    for (int k = 0; k < 2; k++) {
        rmap_free(sum[k]);
        rmap_free(product[k]);
    }
    return st;
}
