/* SPDX-License-Identifier: MIT
 *
 * Answers by blocks of rays. Same bits in any order: a portion's sums are made in the order of its
 * rays, and portions are added exactly.
 */
#include "analysis/sweep/sweep_parts.h"

#include <math.h>
#include <string.h>

#include "analysis/query/quantity_read.h"
#include "base/alloc.h"
#include "base/exact_sum.h"
#include "portion/weight.h"

enum { SUMS = 5 };

struct parts {
    struct rmap_sweep_parts_ask ask;
    const double *flux_per_weight;
    void *with;
    size_t n_source;
    struct rmap_count *count;
    struct rmap_readings readings;
    double own[RMAP_SWEEP_PARTS][SUMS]; /* of the portion in hand */
    struct rmap_exact_sum sum[RMAP_SWEEP_PARTS][SUMS];
};

static bool is_of_place(const struct rmap_sweep_answer *answer)
{
    return answer->kind == RMAP_SWEEP_DETECTOR && answer->of >= RMAP_SWEEP_OF_CENTROID_X;
}

/* The answer is a sum over rays. */
static bool is_sum(const struct rmap_sweep_answer *answer)
{
    return answer->kind <= RMAP_SWEEP_RAYS ||
           (answer->kind == RMAP_SWEEP_DETECTOR && !is_of_place(answer)) ||
           (answer->kind == RMAP_SWEEP_STATISTIC && answer->of == RMAP_SWEEP_THE_FLUX);
}

bool rmap_sweep_has_parts(const struct rmap_sweep_answer *answer)
{
    const int of = answer->of;
    return answer->kind != RMAP_SWEEP_DETECTOR || of == RMAP_SWEEP_OF_FLUX ||
           of == RMAP_SWEEP_OF_MEAN || of == RMAP_SWEEP_OF_REGISTRATIONS ||
           (of >= RMAP_SWEEP_OF_CENTROID_X && of <= RMAP_SWEEP_OF_RMS_RADIUS);
}

static void destroy(void *state)
{
    struct parts *self = state;
    if (!self)
        return;
    if (self->ask.with)
        self->ask.with->destroy(self->with);
    if (self->count)
        rmap_count_fini(self->count);
    rmap_free(self->count);
    rmap_readings_fini(&self->readings);
    rmap_free(self);
}

static enum rmap_status create(const void *context, void **state_ret, struct rmap_error *err)
{
    struct parts *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the parts of an answer");
    memcpy(&self->ask, context, sizeof self->ask);
    self->flux_per_weight = rmap_map_flux_per_weight(self->ask.map);
    self->n_source = rmap_map_scene(self->ask.map)->n_source;
    self->count = rmap_alloc(1, sizeof *self->count);
    enum rmap_status st = self->count
                              ? rmap_count_init(self->count, self->n_source, err)
                              : rmap_error_set(err, RMAP_SYSTEM, "out of memory for a count");
    if (st == RMAP_OK && self->ask.with)
        st = self->ask.with->create(self->ask.with_context, &self->with, err);
    if (st == RMAP_OK)
        *state_ret = self;
    else
        destroy(self);
    return st;
}

void *rmap_sweep_parts_with(void *state)
{
    return ((struct parts *)state)->with;
}

const struct rmap_count *rmap_sweep_parts_count(const void *state)
{
    return ((const struct parts *)state)->count;
}

static double *sums_of(struct parts *self, uint64_t ray)
{
    const double part = (double)ray / (double)self->ask.n_ray * RMAP_SWEEP_PARTS;
    return self->own[part < RMAP_SWEEP_PARTS - 1 ? (size_t)part : RMAP_SWEEP_PARTS - 1];
}

static double flux_of(const struct parts *self, const struct rmap_portion *portion, size_t ray)
{
    return portion->ray.weight[ray] * self->flux_per_weight[portion->ray.source[ray]];
}

static void add_ray(struct parts *self, const struct rmap_matched *rays, size_t ray)
{
    const struct rmap_portion *portion = rays->portion;
    const double weight = portion->ray.weight[ray];
    const size_t source = (size_t)portion->ray.source[ray];
    self->count->rays++;
    self->count->source_weight[source] += weight;
    self->count->source_weight_squared[source] += rmap_weight_squared(weight);
    sums_of(self, portion->ray.id[ray])[0] +=
        self->ask.answer->kind == RMAP_SWEEP_RAYS ? 1.0 : flux_of(self, portion, ray);
}

static void add_registrations(struct parts *self, const struct rmap_matched *rays, size_t ray,
                              size_t row, size_t end)
{
    const struct rmap_portion *portion = rays->portion;
    const uint8_t *counts = rmap_registrations_counted(rays);
    const bool counted = self->ask.answer->of == RMAP_SWEEP_OF_REGISTRATIONS;
    for (; row < end; row++) {
        double x = 0.0, y = 0.0;
        if (portion->registration.detector[row] != self->ask.detector || !counts[row] ||
            rmap_detector_bins_cell(self->ask.bins, portion, row) >= SIZE_MAX - 1)
            continue;
        const double w = counted ? 1.0 : flux_of(self, portion, ray);
        double *sum = sums_of(self, portion->ray.id[ray]);
        if (is_of_place(self->ask.answer))
            rmap_detector_bins_place(self->ask.bins, portion, row, &x, &y);
        x -= self->ask.about[0];
        y -= self->ask.about[1];
        const double term[SUMS] = {w, w * x, w * y, w * x * x, w * y * y};
        for (int k = 0; k < SUMS; k++)
            sum[k] += term[k];
    }
}

static enum rmap_status add_readings(struct parts *self, const struct rmap_matched *rays,
                                     struct rmap_error *err)
{
    const struct rmap_readings *read = &self->readings;
    const enum rmap_status st =
        rmap_quantities_read(self->ask.quantities, rays, &self->readings, err);
    for (size_t i = 0; i < read->n && st == RMAP_OK; i++) {
        double *sum = sums_of(self, rays->portion->ray.id[read->ray[i]]);
        double term = flux_of(self, rays->portion, read->ray[i]) * read->share[i];
        for (int k = 0; k < SUMS; k++, term *= read->value[0][i] - self->ask.about[0])
            sum[k] += term;
    }
    return st;
}

static enum rmap_status add(void *state, const struct rmap_matched *rays, struct rmap_error *err)
{
    struct parts *self = state;
    const struct rmap_portion *portion = rays->portion;
    const enum rmap_sweep_kind kind = self->ask.answer->kind;
    enum rmap_status st = RMAP_OK;
    size_t row = 0;
    if (self->with)
        RMAP_TRY(self->ask.with->add(self->with, rays, err));
    if (!rmap_sweep_has_parts(self->ask.answer))
        return RMAP_OK;
    memset(self->own, 0, sizeof self->own);
    if (kind == RMAP_SWEEP_STATISTIC)
        st = add_readings(self, rays, err);
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_RAY] && kind != RMAP_SWEEP_STATISTIC; i++) {
        const size_t first = row;
        if (kind == RMAP_SWEEP_DETECTOR)
            row += portion->ray.registration_count[i];
        if (rays->match && !rays->match[i])
            continue;
        if (kind == RMAP_SWEEP_DETECTOR)
            add_registrations(self, rays, i, first, row);
        else
            add_ray(self, rays, i);
    }
    for (size_t p = 0; p < RMAP_SWEEP_PARTS; p++)
        for (size_t k = 0; k < SUMS; k++)
            if (self->own[p][k] != 0.0)
                rmap_exact_sum_add(&self->sum[p][k], self->own[p][k]);
out:
    return st;
}

static enum rmap_status merge(void *into, void *from, struct rmap_error *err)
{
    struct parts *self = into;
    struct parts *other = from;
    rmap_count_add(self->count, other->count, self->n_source);
    for (size_t p = 0; p < RMAP_SWEEP_PARTS; p++)
        for (size_t k = 0; k < SUMS; k++)
            rmap_exact_sum_merge(&self->sum[p][k], &other->sum[p][k]);
    return self->with ? self->ask.with->merge(self->with, other->with, err) : RMAP_OK;
}

static size_t blocks(const void *state, struct rmap_fold_block block[RMAP_FOLD_BLOCKS_MAX])
{
    const struct parts *self = state;
    const struct rmap_fold_block own[] = {
        {(void *)self->sum, sizeof self->sum},
        {&self->count->rays, sizeof self->count->rays},
        {self->count->source_weight, self->n_source * sizeof(double)},
        {self->count->source_weight_squared, self->n_source * sizeof(double)}};
    const size_t n = self->with ? self->ask.with->blocks(self->with, block) : 0;
    memcpy(block + n, own, sizeof own);
    return n + sizeof own / sizeof *own;
}

const struct rmap_fold_kind rmap_sweep_parts_kind = {
    .create = create, .destroy = destroy, .add = add, .merge = merge, .blocks = blocks};

rmap_column_set rmap_sweep_parts_columns(const struct rmap_sweep_parts_ask *ask)
{
    rmap_column_set columns = RMAP_COLUMN_BIT(RMAP_RAY_id) | RMAP_COLUMN_BIT(RMAP_RAY_source) |
                              RMAP_COLUMN_BIT(RMAP_RAY_weight);
    if (ask->quantities)
        columns |= ask->quantities->columns;
    if (ask->bins)
        columns |= RMAP_COLUMN_BIT(RMAP_RAY_registration_count) |
                   RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector) |
                   RMAP_COLUMN_BIT(RMAP_REGISTRATION_registered) |
                   RMAP_COLUMN_BIT(RMAP_REGISTRATION_relative) |
                   rmap_detector_bins_columns(ask->bins);
    return columns;
}

/* Central moments of x, or what they make. */
static double value_of(const struct rmap_sweep_parts_ask *ask, const double sum[SUMS])
{
    const struct rmap_sweep_answer *answer = ask->answer;
    const double a = sum[1] / sum[0], b = sum[2] / sum[0], c = sum[3] / sum[0], d = sum[4] / sum[0];
    if (is_of_place(answer))
        return answer->of == RMAP_SWEEP_OF_CENTROID_X   ? ask->about[0] + a
               : answer->of == RMAP_SWEEP_OF_CENTROID_Y ? ask->about[1] + b
                                                        : sqrt(fmax(c + d - a * a - b * b, 0.0));
    const double m2 = b - a * a, m3 = c - 3.0 * a * b + 2.0 * a * a * a,
                 m4 = d - 4.0 * a * c + 6.0 * a * a * b - 3.0 * a * a * a * a;
    return answer->of == RMAP_SWEEP_THE_MEAN        ? ask->about[0] + a
           : answer->of == RMAP_SWEEP_THE_DEVIATION ? sqrt(fmax(m2, 0.0))
           : answer->of == RMAP_SWEEP_THE_SKEWNESS  ? m3 / (m2 * sqrt(m2))
                                                    : m4 / (m2 * m2) - 3.0;
}

void rmap_sweep_parts_values(const void *state, double value, double part[RMAP_SWEEP_PARTS])
{
    const struct parts *self = state;
    const bool sums = is_sum(self->ask.answer);
    double all = 0.0;
    if (!rmap_sweep_has_parts(self->ask.answer))
        return;
    for (size_t p = 0; p < RMAP_SWEEP_PARTS; p++) {
        double sum[SUMS];
        for (size_t k = 0; k < SUMS; k++)
            sum[k] = rmap_exact_sum_value(&self->sum[p][k]);
        part[p] = sums ? sum[0] : value_of(&self->ask, sum);
        all += part[p];
    }
    for (size_t p = 0; p < RMAP_SWEEP_PARTS && sums && all > 0.0; p++)
        part[p] *= value / all; /* in the answer's unit */
}

double rmap_sweep_parts_error(const struct rmap_sweep_answer *answer,
                              const double a[RMAP_SWEEP_PARTS], const double b[RMAP_SWEEP_PARTS])
{
    const double n = RMAP_SWEEP_PARTS;
    double mean = 0.0, squares = 0.0;
    for (size_t p = 0; p < RMAP_SWEEP_PARTS; p++)
        mean += (a[p] - b[p]) / n;
    for (size_t p = 0; p < RMAP_SWEEP_PARTS; p++)
        squares += (a[p] - b[p] - mean) * (a[p] - b[p] - mean);
    return sqrt(is_sum(answer) ? squares * n / (n - 1.0) : squares / (n * (n - 1.0)));
}
