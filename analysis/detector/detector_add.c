/* SPDX-License-Identifier: MIT
 *
 * A portion's registrations added to a detector's sums, ray by ray.
 */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "analysis/detector/detector_sums.h"
#include "base/alloc.h"
#include "optics/spectrum.h"

struct rmap_detector_hit {
    size_t cell;
    size_t leg; /* row of /segment */
};

/* Channels' colours of one space in the terms of another one's mode. */
static void channel_colours_as(const struct rmap_scene *scene, enum rmap_colour_mode mode,
                               double (*colour)[3])
{
    rmap_channel_colours(&scene->channels, scene->flux_unit == RMAP_FLUX_LM, colour);
    for (int i = 0; i < scene->channels.n && scene->channels.mode != mode; i++) {
        const double given[3] = {colour[i][0], colour[i][1], colour[i][2]};
        if (mode == RMAP_COLOUR_RGB)
            rmap_xyz_to_rgb(given, colour[i]);
        else
            rmap_rgb_to_xyz(given, colour[i]);
    }
}

/* A registration's flux spread over the three colour components, rounded to quanta: integers
 * add up the same in any order. */
static void add_colour(struct rmap_detector_sums *sums, const struct rmap_portion *portion,
                       const struct rmap_detector_hit *hit, double flux)
{
    const uint16_t *share = portion->colour + hit->leg * (size_t)portion->n_channel;
    double sum[3] = {0.0, 0.0, 0.0};
    for (int i = 0; i < portion->n_channel; i++)
        for (int k = 0; k < 3; k++)
            sum[k] += share[i] * sums->channel_colour[i][k];
    for (size_t k = 0; k < 3; k++)
        sums->colour[3 * hit->cell + k] += llround(sum[k] / 65535.0 * flux / sums->quantum);
}

/* Of a leg's light, the part of 65535 that channel c has; or how much of it is seen. */
static double share_of(const struct rmap_detector_sums *sums, const struct rmap_portion *portion,
                       size_t leg, size_t c)
{
    const uint16_t *share = portion->colour + leg * (size_t)portion->n_channel;
    double seen = 0.0;
    if (!sums->ask.luminous)
        return share[c];
    for (int i = 0; i < portion->n_channel; i++)
        seen += share[i] * sums->channel_luminous[i];
    return seen;
}

/* Registrations of one ray in the same cell (or, cell n_cell, in any), channel by channel. */
static void add_shares(struct rmap_detector_sums *sums, const struct rmap_portion *portion,
                       const struct rmap_detector_hit *hit, size_t n_hit, size_t source,
                       size_t cell, double weight)
{
    const size_t stride = sums->n_cell + 1;
    for (size_t c = 0; c < sums->n_channel; c++) {
        double share = 0.0;
        for (size_t k = 0; k < n_hit; k++)
            share += share_of(sums, portion, hit[k].leg, c);
        if (share == 0.0)
            continue;
        const uint64_t q = (uint64_t)llround(weight * share);
        uint64_t *sum = sums->share + (source * sums->n_channel + c) * stride + cell;
        sum[0] += q;
        sum[sums->n_share / 2] += q * q;
    }
}

static int by_cell(const void *a, const void *b)
{
    const struct rmap_detector_hit *left = a, *right = b;
    if (left->cell != right->cell)
        return left->cell < right->cell ? -1 : 1;
    return (left->leg > right->leg) - (left->leg < right->leg);
}

/* The ray's hits, in any order. */
static void add_hits(struct rmap_detector_sums *sums, const struct rmap_portion *portion,
                     size_t ray, size_t n_hit)
{
    struct rmap_detector_hit *hit = sums->hit;
    const size_t source = (size_t)portion->ray.source[ray];
    const double weight = portion->ray.weight[ray], all = weight * (double)n_hit;
    const double flux = weight * rmap_map_flux_per_weight(sums->ask.map)[source];
    if (n_hit > 1)
        qsort(hit, n_hit, sizeof *hit, by_cell);
    for (size_t first = 0, last; first < n_hit; first = last) {
        for (last = first + 1; last < n_hit && hit[last].cell == hit[first].cell; last++)
            continue;
        const double q = weight * (double)(last - first);
        double *sum = sums->weight + source * sums->n_cell + hit[first].cell;
        sum[0] += q;
        sum[sums->n_source * sums->n_cell] += q * q;
        if (sums->n_channel)
            add_shares(sums, portion, hit + first, last - first, source, hit[first].cell, weight);
        for (size_t k = first; k < last && sums->n_colour; k++)
            add_colour(sums, portion, &hit[k], flux);
    }
    sums->total[source] += all;
    sums->total[sums->n_source + source] += all * all;
    if (sums->n_channel)
        add_shares(sums, portion, hit, n_hit, source, sums->n_cell, weight);
}

static void add_place(struct rmap_detector_sums *sums, const struct rmap_portion *portion,
                      size_t ray, size_t row)
{
    const double weight = portion->ray.weight[ray];
    struct rmap_exact_sum *sum = sums->centre + 4 * portion->ray.source[ray];
    double x, y;
    rmap_detector_bins_place(&sums->ask.bins, portion, row, &x, &y);
    rmap_exact_sum_add(&sum[0], weight);
    rmap_exact_sum_add(&sum[1], weight * x);
    rmap_exact_sum_add(&sum[2], weight * y);
    rmap_exact_sum_add(&sum[3], weight * (x * x + y * y));
}

static enum rmap_status take_hit(struct rmap_detector_sums *sums, size_t n_hit, size_t cell,
                                 size_t leg, struct rmap_error *err)
{
    enum rmap_status st = RMAP_RESERVE(sums->hit, sums->cap_hit, n_hit + 1, err);
    if (st != RMAP_OK)
        return st;
    sums->hit[n_hit] = (struct rmap_detector_hit){cell, leg};
    return RMAP_OK;
}

/* Registrations [row, end) of ray row `ray`, whose legs begin at row `segment`. */
static enum rmap_status add_ray(struct rmap_detector_sums *sums, const struct rmap_matched *rays,
                                size_t ray, size_t row, size_t end, size_t segment,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *portion = rays->portion;
    const uint8_t *counts = rmap_registrations_counted(rays);
    size_t n_hit = 0;
    for (; row < end; row++) {
        if (portion->registration.detector[row] != sums->ask.detector || !counts[row])
            continue;
        const uint32_t leg = portion->registration.segment[row];
        const size_t cell = rmap_detector_bins_cell(&sums->ask.bins, portion, row);
        if (cell == SIZE_MAX - 1 || (uint32_t)portion->ray.source[ray] >= sums->n_source ||
            leg >= portion->ray.segment_count[ray])
            return rmap_error_set(err, RMAP_FORMAT,
                                  "damaged map: ray %" PRIu64
                                  " is registered where there is no cell, or on leg %u, which it "
                                  "has not",
                                  portion->ray.id[ray], leg);
        if (cell == SIZE_MAX)
            continue;
        RMAP_TRY(take_hit(sums, n_hit++, cell, segment + leg, err));
        if (sums->centre)
            add_place(sums, portion, ray, row);
    }
    if (n_hit > 0)
        add_hits(sums, portion, ray, n_hit);
out:
    return st;
}

static bool same_channels(const struct rmap_channels *a, const struct rmap_channels *b)
{
    bool same = a->n == b->n && a->mode == b->mode;
    for (int i = 0; same && i < a->n; i++)
        same = a->wavelength_nm[i] == b->wavelength_nm[i];
    return same;
}

/* Says which rays can be asked for instead: the same words, whichever portion was read first. */
static enum rmap_status tell_other_channels(const struct rmap_map *map, struct rmap_error *err)
{
    const struct rmap_channels *first = &rmap_map_scene(map)->channels;
    const size_t n = rmap_map_n_portion(map);
    size_t p = 0;
    char remedy[64] = "";
    while (p < n) {
        const size_t space = (size_t)rmap_map_portion(map, p)->space;
        if (!same_channels(&rmap_map_scene_of(map, space)->channels, first))
            break;
        p++;
    }
    if (p > 0 && p < n)
        (void)snprintf(remedy, sizeof remedy, ", as those of --where 'ray < %llu' have",
                       (unsigned long long)rmap_map_portion(map, p)->first_ray);
    return rmap_error_set(err, RMAP_INPUT,
                          "parts of this map were traced in other wavelengths: a spectrum needs "
                          "the same ones throughout%s",
                          remedy);
}

/* Channels of the portion's colour space: for colours any do, for shares those of space 0. */
static enum rmap_status enter_space(struct rmap_detector_sums *sums,
                                    const struct rmap_matched *rays, struct rmap_error *err)
{
    const struct rmap_scene *first = rmap_map_scene(sums->ask.map);
    const struct rmap_scene *scene = rmap_map_scene_of(sums->ask.map, rays->space);
    if ((size_t)sums->space == rays->space)
        return RMAP_OK;
    sums->space = (int32_t)rays->space;
    if (sums->n_colour)
        channel_colours_as(scene, first->channels.mode, sums->channel_colour);
    for (int i = 0; sums->ask.luminous && i < scene->channels.n; i++)
        sums->channel_luminous[i] =
            rmap_channel_luminous(&scene->channels, i) / sums->luminous_unit;
    if (sums->n_channel && !sums->ask.luminous &&
        !same_channels(&scene->channels, &first->channels))
        return tell_other_channels(sums->ask.map, err);
    return RMAP_OK;
}

enum rmap_status rmap_detector_sums_add(void *state, const struct rmap_matched *rays,
                                        struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_detector_sums *sums = state;
    const struct rmap_portion *portion = rays->portion;
    size_t row = 0, segment = 0;
    RMAP_TRY(enter_space(sums, rays, err));
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_RAY]; i++) {
        const size_t end = row + portion->ray.registration_count[i];
        if (end > row && (!rays->match || rays->match[i]))
            RMAP_TRY(add_ray(sums, rays, i, row, end, segment, err));
        row = end;
        segment += portion->ray.segment_count[i];
    }
out:
    return st;
}
