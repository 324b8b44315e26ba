/* SPDX-License-Identifier: MIT
 *
 * Sums over the places where rays were registered on a plane, about a given centre: what centroid,
 * spot size, encircled energy and MTF are made of.
 */
#include "analysis/detector/spot_sums.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"

struct rmap_spot_point {
    double x, y;
    uint32_t ring;
};

enum { SUMS = RMAP_SPOT_VECTOR + RMAP_SPOT_GRAM };

static void destroy(void *state)
{
    struct rmap_spot_sums *self = state;
    if (!self)
        return;
    rmap_free(self->sum);
    rmap_free(self->ring);
    rmap_free(self->wave);
    rmap_free(self->point);
    rmap_free(self->phase);
    rmap_free(self);
}

static size_t n_wave(const struct rmap_spot_sums *self)
{
    return self->n_source * 2 * self->ask.n_frequency * RMAP_SPOT_WAVES;
}

static enum rmap_status create(const void *context, void **state_ret, struct rmap_error *err)
{
    const struct rmap_spot_ask *ask = context;
    struct rmap_spot_sums *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a spot");
    self->ask = *ask;
    self->n_source = rmap_map_scene(ask->map)->n_source;
    const double *size = ask->bins.detector->size;
    self->radius_max = ldexp(1.0, ilogb(2.0 * hypot(size[0], size[1])) + 1);
    self->n_ring = ask->moments_alone ? 0 : 3 * self->n_source * RMAP_SPOT_RINGS;
    enum rmap_status st = RMAP_OK;
    if (8 * (self->n_ring + n_wave(self)) > (size_t)1 << 30)
        st = rmap_error_set(err, RMAP_USAGE,
                            "a spot of %zu sources takes more than 1 GB on every thread: choose "
                            "some with --where 'source(NAME)' in a map of their own",
                            self->n_source);
    if (st == RMAP_OK) {
        self->sum = rmap_alloc(self->n_source * SUMS, sizeof *self->sum);
        self->ring = rmap_alloc(self->n_ring + 1, sizeof *self->ring);
        self->wave = rmap_alloc(n_wave(self) + 1, sizeof *self->wave);
        self->phase = rmap_alloc(2 * ask->n_frequency + 1, sizeof *self->phase);
        if (!self->sum || !self->ring || !self->wave || !self->phase)
            st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a spot");
    }
    if (st == RMAP_OK)
        *state_ret = self;
    else
        destroy(self);
    return st;
}

/* ---- rings ---- */

/* Of the bits of r / radius_max < 1: exponent and the first bits of the mantissa. */
static uint32_t ring_of(const struct rmap_spot_sums *self, double radius)
{
    const double share = radius / self->radius_max; /* by a power of 2: exact */
    const int octave = share > 0.0 ? -ilogb(share) : RMAP_SPOT_OCTAVES + 1; /* from 1 on */
    if (octave > RMAP_SPOT_OCTAVES)
        return 0;
    if (octave < 1)
        return RMAP_SPOT_RINGS - 1;
    const double within = (ldexp(share, octave) - 1.0) * RMAP_SPOT_PER_OCTAVE;
    return 1 + (uint32_t)(RMAP_SPOT_OCTAVES - octave) * RMAP_SPOT_PER_OCTAVE + (uint32_t)within;
}

double rmap_spot_ring_end(const struct rmap_spot_sums *self, size_t ring)
{
    const int octave =
        RMAP_SPOT_OCTAVES - (int)((ring + RMAP_SPOT_PER_OCTAVE - 1) / RMAP_SPOT_PER_OCTAVE) + 1;
    const double within = (double)((ring + RMAP_SPOT_PER_OCTAVE - 1) % RMAP_SPOT_PER_OCTAVE + 1);
    if (ring == 0)
        return ldexp(self->radius_max, -RMAP_SPOT_OCTAVES);
    return ldexp(self->radius_max * (1.0 + within / RMAP_SPOT_PER_OCTAVE), -octave);
}

static int by_ring(const void *a, const void *b)
{
    const struct rmap_spot_point *left = a, *right = b;
    return (left->ring > right->ring) - (left->ring < right->ring);
}

static void add_rings(struct rmap_spot_sums *self, size_t source, double weight, size_t n)
{
    double *ring = self->ring + 3 * source * RMAP_SPOT_RINGS;
    const double all = weight * (double)n;
    double inside = 0.0;
    if (n > 1)
        qsort(self->point, n, sizeof *self->point, by_ring);
    for (size_t i = 0; i < n; i++) {
        double *at = ring + self->point[i].ring;
        const double before = inside * inside;
        inside += weight;
        at[0] += weight;
        at[RMAP_SPOT_RINGS] += inside * inside - before;
        at[2 * RMAP_SPOT_RINGS] += weight * all;
    }
}

/* ---- moments and waves ---- */

static void add_moments(struct rmap_spot_sums *self, size_t source, double weight, size_t n)
{
    struct rmap_exact_sum *sum = self->sum + source * SUMS;
    double v[RMAP_SPOT_VECTOR] = {0.0};
    for (size_t i = 0; i < n; i++) {
        const double x = self->point[i].x, y = self->point[i].y;
        const double term[RMAP_SPOT_VECTOR] = {1.0, x, y, x * x, y * y};
        for (int k = 0; k < RMAP_SPOT_VECTOR; k++)
            v[k] += weight * term[k];
    }
    for (int k = 0; k < RMAP_SPOT_VECTOR; k++)
        rmap_exact_sum_add(sum++, v[k]);
    for (int j = 0; j < RMAP_SPOT_VECTOR; j++)
        for (int k = j; k < RMAP_SPOT_VECTOR; k++)
            rmap_exact_sum_add(sum++, v[j] * v[k]);
}

/* cos and sin of 0, 1, 2 ... times the phase, by turning on. */
static void add_phases(double (*phase)[2], size_t n, double turn, double weight)
{
    const double c = cos(turn), s = sin(turn);
    double at[2] = {weight, 0.0};
    for (size_t k = 0; k < n; k++) {
        phase[k][0] += at[0];
        phase[k][1] += at[1];
        const double next = at[0] * c - at[1] * s;
        at[1] = at[0] * s + at[1] * c;
        at[0] = next;
    }
}

static void add_waves(struct rmap_spot_sums *self, size_t source, double weight, size_t n)
{
    const struct rmap_spot_ask *ask = &self->ask;
    const size_t n_phase = 2 * ask->n_frequency;
    const double turn = 2.0 * RMAP_PI * ask->frequency_step;
    const double t[2] = {cos(ask->tangential_rad), sin(ask->tangential_rad)};
    const double q = weight * (double)n;
    memset(self->phase, 0, n_phase * sizeof *self->phase);
    for (size_t i = 0; i < n; i++) {
        const double x = self->point[i].x, y = self->point[i].y;
        add_phases(self->phase, ask->n_frequency, turn * (x * t[0] + y * t[1]), weight);
        add_phases(self->phase + ask->n_frequency, ask->n_frequency, turn * (y * t[0] - x * t[1]),
                   weight);
    }
    int64_t *wave = self->wave + source * n_phase * RMAP_SPOT_WAVES;
    for (size_t k = 0; k < n_phase; k++, wave += RMAP_SPOT_WAVES) {
        const double c = self->phase[k][0], s = self->phase[k][1];
        const double term[RMAP_SPOT_WAVES] = {c, s, c * c, c * s, s * s, q * c, q * s};
        for (int i = 0; i < RMAP_SPOT_WAVES; i++)
            wave[i] += (int64_t)rint(term[i] * RMAP_SPOT_FIXED);
    }
}

/* ---- rays ---- */

static enum rmap_status add_ray(struct rmap_spot_sums *self, const struct rmap_matched *rays,
                                size_t ray, size_t row, size_t end, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *portion = rays->portion;
    const uint8_t *counts = rmap_registrations_counted(rays);
    const size_t source = (size_t)portion->ray.source[ray];
    const double weight = portion->ray.weight[ray];
    size_t n = 0;
    for (; row < end; row++) {
        if (portion->registration.detector[row] != self->ask.detector || !counts[row])
            continue;
        if ((uint32_t)portion->ray.source[ray] >= self->n_source)
            return rmap_error_set(err, RMAP_FORMAT,
                                  "damaged map: a ray of the block from ray %" PRIu64
                                  " on has a source that is none",
                                  portion->first_ray);
        if (rmap_detector_bins_cell(&self->ask.bins, portion, row) >= SIZE_MAX - 1)
            continue;
        RMAP_TRY(RMAP_RESERVE(self->point, self->cap_point, n + 1, err));
        struct rmap_spot_point *point = &self->point[n++];
        rmap_detector_bins_place(&self->ask.bins, portion, row, &point->x, &point->y);
        point->x -= self->ask.centre[0];
        point->y -= self->ask.centre[1];
        if (self->n_ring)
            point->ring = ring_of(self, hypot(point->x, point->y));
    }
    if (n == 0)
        return RMAP_OK;
    add_moments(self, source, weight, n);
    if (self->ask.n_frequency)
        add_waves(self, source, weight, n);
    if (self->n_ring)
        add_rings(self, source, weight, n);
out:
    return st;
}

static enum rmap_status add(void *state, const struct rmap_matched *rays, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *portion = rays->portion;
    size_t row = 0;
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_RAY] && st == RMAP_OK; i++) {
        const size_t end = row + portion->ray.registration_count[i];
        if (end > row && (!rays->match || rays->match[i]))
            st = add_ray(state, rays, i, row, end, err);
        row = end;
    }
    return st;
}

static enum rmap_status merge(void *into, void *from, struct rmap_error *err)
{
    struct rmap_spot_sums *self = into;
    const struct rmap_spot_sums *other = from;
    (void)err;
    for (size_t i = 0; i < self->n_source * SUMS; i++)
        rmap_exact_sum_merge(&self->sum[i], &other->sum[i]);
    for (size_t i = 0; i < self->n_ring; i++)
        self->ring[i] += other->ring[i];
    for (size_t i = 0; i < n_wave(self); i++)
        self->wave[i] += other->wave[i];
    return RMAP_OK;
}

/* ---- as bytes ---- */

static size_t blocks(const void *state, struct rmap_fold_block block[RMAP_FOLD_BLOCKS_MAX])
{
    const struct rmap_spot_sums *self = state;
    block[0] = (struct rmap_fold_block){self->sum, self->n_source * SUMS * sizeof *self->sum};
    block[1] = (struct rmap_fold_block){self->ring, self->n_ring * sizeof *self->ring};
    block[2] = (struct rmap_fold_block){self->wave, n_wave(self) * sizeof *self->wave};
    return 3;
}

static bool may_count(const void *context, const struct rmap_portion_info *portion)
{
    const struct rmap_spot_ask *ask = context;
    return (portion->summary.detectors >> (ask->detector % 64) & 1) != 0;
}

rmap_column_set rmap_spot_sums_columns(const struct rmap_spot_ask *ask)
{
    return RMAP_COLUMN_BIT(RMAP_RAY_source) | RMAP_COLUMN_BIT(RMAP_RAY_weight) |
           RMAP_COLUMN_BIT(RMAP_RAY_registration_count) |
           RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector) |
           RMAP_COLUMN_BIT(RMAP_REGISTRATION_registered) |
           RMAP_COLUMN_BIT(RMAP_REGISTRATION_relative) | rmap_detector_bins_columns(&ask->bins);
}

const struct rmap_fold_kind rmap_spot_sums_kind = {.create = create,
                                                   .destroy = destroy,
                                                   .add = add,
                                                   .merge = merge,
                                                   .blocks = blocks,
                                                   .may_count = may_count};
