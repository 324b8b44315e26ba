/* SPDX-License-Identifier: MIT
 *
 * What a detector caught, as sums that do not depend on the order of adding.
 */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/criterion/registration_response.h"
#include "analysis/detector/detector_sums.h"
#include "analysis/table/flux_error.h"
#include "base/alloc.h"
#include "base/unit.h"
#include "io/map/map_dim.h"
#include "optics/spectrum.h"
#include "portion/weight.h"
#include "trace/tally.h"

static enum rmap_status detector_sums_add(void *sums, const struct rmap_matched *rays,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* The map's whole flux, in units of the quantum: leaves room for a ray to be registered 2^11
 * times, and 2^52 / 1e9 rays = 4.5e6 steps for a single one. */
static const double QUANTA = 4503599627370496.0; /* 2^52 */

enum rmap_status rmap_detector_sums_init(struct rmap_detector_sums *sums,
                                         const struct rmap_map *map, int32_t detector, bool colour,
                                         struct rmap_error *err)
{
    struct rmap_detector_ask ask = {.map = map, .detector = detector, .colour = colour};
    rmap_detector_bins_own(rmap_map_scene(map), detector, &ask.bins);
    return rmap_detector_sums_init_as(sums, &ask, err);
}

bool rmap_detector_ask_lumens(const struct rmap_detector_ask *ask)
{
    return ask->luminous || (ask->weighed && ask->bins.detector->response->lumens) ||
           rmap_map_scene(ask->map)->flux_unit == RMAP_FLUX_LM;
}

static double rmap_channel_luminous(const struct rmap_channels *channels, int channel)
{
    double alone[RMAP_CHANNEL_MAX] = {0.0};
    alone[channel] = 1.0;
    return rmap_luminous_efficacy(channels, alone);
}

/* lm/W of the light of a channel; the most of any, 1 where none is seen. */
static double luminous_most(const struct rmap_channels *channels)
{
    double most = 0.0;
    for (int i = 0; i < channels->n; i++)
        most = fmax(most, rmap_channel_luminous(channels, i));
    return most > 0.0 ? most : 1.0;
}

/* 1 where it makes nothing of any light. */
static double response_most(const struct rmap_response *response)
{
    const double most = rmap_response_most(response);
    return most > 0.0 ? most : 1.0;
}

/* In their own mode's terms, or in those of `mode`. */
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

/* Lumens (of an amount of light: lm s) that a unit of flux on a channel is where V(lambda) is 1. */
static double lumens_per_unit(const struct rmap_scene *scene, int channel)
{
    switch (scene->flux_unit) {
    case RMAP_FLUX_LM:
        return 1.0;
    case RMAP_FLUX_PHOTONS:
    case RMAP_FLUX_PHOTON_RATE:
        return RMAP_LUMENS_PER_WATT * RMAP_HC_J / scene->channels.wavelength_nm[channel];
    default:
        return RMAP_LUMENS_PER_WATT;
    }
}

/* Of a unit of flux on each channel, lm (or lm s); the most of any. */
static double find_xyz(const struct rmap_scene *scene, double (*sums)[RMAP_XYZ_SUMS])
{
    double xyz[RMAP_CHANNEL_MAX][3], most = 0.0;
    channel_colours_as(scene, RMAP_COLOUR_SPECTRAL, xyz);
    for (int i = 0; i < scene->channels.n; i++) {
        const double unit = lumens_per_unit(scene, i);
        double bend[3];
        sums[i][6] = unit * xyz[i][1];
        rmap_channel_bend(&scene->channels, i, scene->flux_unit == RMAP_FLUX_LM, bend);
        for (int k = 0; k < 3; k++)
            xyz[i][k] += bend[k];
        for (int k = 0; k < 3; k++) {
            sums[i][k] = unit * xyz[i][k];
            sums[i][3 + k] = unit * (xyz[i][k] + xyz[i][(k + 1) % 3]);
            most = fmax(most, sums[i][3 + k]);
        }
    }
    return most > 0.0 ? most : 1.0;
}

/* Where a channel's sum of a cell, or in all, stands. */
static size_t share_place(const struct rmap_detector_sums *sums, size_t source, size_t channel,
                          size_t cell)
{
    const size_t row = sums->n_cell + 1, spectral = sums->ask.channels ? row : 1;
    const size_t behind = channel < sums->n_spectral ? 0 : channel - sums->n_spectral;
    const size_t of_source =
        sums->n_spectral * spectral + (sums->n_channel - sums->n_spectral) * row;
    return source * of_source + (channel - behind) * spectral + behind * row +
           (channel < sums->n_spectral && spectral == 1 ? 0 : cell);
}

/* The arrays of sums, for those who copy them as bytes. */
static size_t blocks(const void *state, struct rmap_fold_block block[RMAP_FOLD_BLOCKS_MAX])
{
    const struct rmap_detector_sums *sums = state;
    block[0] = (struct rmap_fold_block){sums->weight, sums->n_weight * sizeof *sums->weight};
    block[1] = (struct rmap_fold_block){sums->total, 2 * sums->n_source * sizeof *sums->total};
    block[2] = (struct rmap_fold_block){sums->colour, sums->n_colour * sizeof *sums->colour};
    block[3] = (struct rmap_fold_block){sums->share, sums->n_share * sizeof *sums->share};
    block[4] = (struct rmap_fold_block){
        sums->centre, sums->centre ? 4 * sums->n_source * sizeof *sums->centre : 0};
    return 5;
}

static enum rmap_status check_size(const struct rmap_detector_sums *sums, struct rmap_error *err)
{
    const size_t nbytes = 8 * (sums->n_weight + sums->n_colour + sums->n_share);
    if (nbytes <= RMAP_DETECTOR_SUMS_NBYTES_MAX)
        return RMAP_OK;
    return rmap_error_set(err, RMAP_USAGE,
                          "sums for %u x %u cells%s take %.1f GB on every thread, and 1 is the "
                          "most: ask for fewer cells or a smaller region",
                          sums->ask.bins.n[0], sums->ask.bins.n[1],
                          sums->n_share ? " of every wavelength" : "", 1e-9 * (double)nbytes);
}

enum rmap_status rmap_detector_sums_init_as(struct rmap_detector_sums *sums,
                                            const struct rmap_detector_ask *ask,
                                            struct rmap_error *err)
{
    const struct rmap_scene *scene = rmap_map_scene(ask->map);
    const uint32_t *n = ask->bins.n;
    *sums = (struct rmap_detector_sums){
        .ask = *ask, .n_source = scene->n_source, .n_cell = (size_t)n[0] * n[1], .space = -1};
    sums->n_weight = 2 * sums->n_source * sums->n_cell;
    sums->n_colour = ask->colour ? 3 * sums->n_cell : 0;
    sums->n_spectral =
        (ask->channels && !ask->luminous) || ask->xyz ? (size_t)scene->channels.n : 0;
    sums->n_seen = ask->luminous || ask->weighed;
    sums->n_xyz = ask->xyz ? RMAP_XYZ_SUMS : 0;
    sums->n_channel = sums->n_spectral + sums->n_seen + sums->n_xyz;
    sums->seen_unit = ask->luminous  ? luminous_most(&scene->channels)
                      : ask->weighed ? response_most(ask->bins.detector->response)
                                     : 1.0;
    sums->xyz_unit = ask->xyz ? find_xyz(scene, sums->channel_xyz) : 1.0;
    sums->n_share = 2 * share_place(sums, sums->n_source, 0, 0);
    double flux = 0.0;
    for (size_t s = 0; s < scene->n_source; s++)
        flux += scene->source[s].flux * rmap_map_dimmed(ask->map, s);
    sums->quantum = flux > 0.0 ? flux / QUANTA : 1.0;
    enum rmap_status st = check_size(sums, err);
    if (st != RMAP_OK)
        return st;
    sums->weight = rmap_alloc(sums->n_weight, sizeof *sums->weight);
    sums->total = rmap_alloc(2 * sums->n_source, sizeof *sums->total);
    sums->colour = rmap_alloc(sums->n_colour + 1, sizeof *sums->colour);
    sums->share = rmap_alloc(sums->n_share + 1, sizeof *sums->share);
    if (ask->centre)
        sums->centre = rmap_alloc(4 * sums->n_source, sizeof *sums->centre);
    if (sums->weight && sums->total && sums->colour && sums->share &&
        (sums->centre || !ask->centre))
        return RMAP_OK;
    rmap_detector_sums_fini(sums);
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a detector of %u x %u cells", n[0],
                          n[1]);
}

void rmap_detector_sums_fini(struct rmap_detector_sums *sums)
{
    rmap_free(sums->weight);
    rmap_free(sums->total);
    rmap_free(sums->colour);
    rmap_free(sums->share);
    rmap_free(sums->centre);
    rmap_free(sums->hit);
    *sums = (struct rmap_detector_sums){0};
}

/* Of a source that was put out nothing is registered. */
static bool is_off(const struct rmap_detector_sums *sums, size_t source)
{
    return !(rmap_map_dimmed(sums->ask.map, source) > 0.0);
}

void rmap_detector_sums_add_tally(struct rmap_detector_sums *sums, const struct rmap_tally *tally)
{
    for (size_t s = 0; s < sums->n_source; s++) {
        const double *image = rmap_tally_image(tally, (size_t)sums->ask.detector, s);
        const size_t first = (size_t)(image - tally->image);
        double *weight = sums->weight + s * sums->n_cell;
        for (size_t c = 0; c < sums->n_cell && !is_off(sums, s); c++) {
            weight[c] += image[c];
            const double squared = rmap_tally_squared(tally, first + c);
            weight[c + sums->n_source * sums->n_cell] += squared;
            sums->total[s] += image[c];
            sums->total[sums->n_source + s] += squared;
        }
    }
}

void rmap_detector_sums_add_flux(const struct rmap_map *map, size_t source, double w, double w2,
                                 double *flux, double *variance)
{
    *flux += rmap_map_flux(map, source, w);
    *variance += rmap_flux_variance_if_rays(rmap_map_flux_per_weight(map)[source],
                                            rmap_map_emitted(map)[source], w, w2);
}

void rmap_detector_sums_channel(const struct rmap_detector_sums *sums, size_t first, size_t last,
                                size_t channel, size_t cell, double *flux_ret, double *error_ret)
{
    const size_t behind = sums->n_spectral + sums->n_seen;
    const double square = 65535.0 * 65535.0;
    const double unit = channel >= behind                             ? sums->xyz_unit
                        : channel < sums->n_spectral && sums->ask.xyz ? 1.0
                                                                      : sums->seen_unit;
    double variance = 0.0;
    *flux_ret = 0.0;
    for (size_t s = first; s < last; s++) {
        const uint64_t *share = sums->share + share_place(sums, s, channel, cell);
        const double n = rmap_map_emitted(sums->ask.map)[s], w = (double)share[0] / RMAP_SHARE_UNIT;
        const double w2 = (double)share[sums->n_share / 2] / square;
        /* Two parts per ray may be rounded off: where all rays are alike, that is all there is. */
        const double rays =
            cell < sums->n_cell ? sums->weight[s * sums->n_cell + cell] : sums->total[s];
        rmap_detector_sums_add_flux(sums->ask.map, s, w,
                                    fmax(w2, fmin(w * w / n, w2 + 2.0 * rays / square)), flux_ret,
                                    &variance);
    }
    *flux_ret *= unit;
    *error_ret = rmap_flux_error(variance) * unit;
}

double rmap_detector_sums_crowd(const struct rmap_detector_sums *sums)
{
    double all = 0.0, others = 0.0;
    for (size_t c = 0; c < sums->n_cell; c++) {
        double weight = 0.0;
        for (size_t s = 0; s < sums->n_source; s++)
            weight += sums->weight[s * sums->n_cell + c];
        all += weight;
        others += weight * fmax(weight - 1.0, 0.0);
    }
    return all > 0.0 ? fmax(others / all, all / (double)sums->n_cell) : 0.0;
}

void rmap_detector_sums_merge(struct rmap_detector_sums *into,
                              const struct rmap_detector_sums *from)
{
    for (size_t i = 0; i < into->n_weight; i++)
        into->weight[i] += from->weight[i];
    for (size_t i = 0; i < 2 * into->n_source; i++)
        into->total[i] += from->total[i];
    for (size_t i = 0; i < into->n_colour; i++)
        into->colour[i] += from->colour[i];
    for (size_t i = 0; i < into->n_share; i++)
        into->share[i] += from->share[i];
    for (size_t i = 0; into->centre && i < 4 * into->n_source; i++)
        rmap_exact_sum_merge(&into->centre[i], &from->centre[i]);
}

/* ---- as a fold ---- */

static void destroy(void *state)
{
    if (state)
        rmap_detector_sums_fini(state);
    rmap_free(state);
}

static enum rmap_status create(const void *context, void **state_ret, struct rmap_error *err)
{
    struct rmap_detector_sums *sums = rmap_alloc(1, sizeof *sums);
    if (!sums)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a detector");
    enum rmap_status st = rmap_detector_sums_init_as(sums, context, err);
    if (st == RMAP_OK)
        *state_ret = sums;
    else
        rmap_free(sums);
    return st;
}

static enum rmap_status merge(void *into, void *from, struct rmap_error *err)
{
    (void)err;
    rmap_detector_sums_merge(into, from);
    return RMAP_OK;
}

static bool may_count(const void *context, const struct rmap_portion_info *portion)
{
    const struct rmap_detector_ask *ask = context;
    return (portion->summary.detectors >> (ask->detector % 64) & 1) != 0;
}

rmap_column_set rmap_detector_sums_columns(const struct rmap_detector_ask *ask)
{
    rmap_column_set columns =
        RMAP_COLUMN_BIT(RMAP_RAY_source) | RMAP_COLUMN_BIT(RMAP_RAY_weight) |
        RMAP_COLUMN_BIT(RMAP_RAY_segment_count) | RMAP_COLUMN_BIT(RMAP_RAY_registration_count) |
        RMAP_COLUMN_BIT(RMAP_REGISTRATION_segment) | RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector) |
        RMAP_COLUMN_BIT(RMAP_REGISTRATION_registered) | rmap_detector_bins_columns(&ask->bins);
    if (ask->centre)
        columns |= RMAP_COLUMN_BIT(RMAP_REGISTRATION_relative);
    if (ask->colour || ask->channels || ask->luminous || ask->xyz)
        columns |= RMAP_COLUMN_BIT(RMAP_SEGMENT_colour);
    if (ask->weighed)
        columns |= RMAP_RESPONSE_COLUMNS;
    return columns;
}

const struct rmap_fold_kind rmap_detector_sums_kind = {.create = create,
                                                       .destroy = destroy,
                                                       .add = detector_sums_add,
                                                       .merge = merge,
                                                       .blocks = blocks,
                                                       .may_count = may_count};

/* A portion's registrations added to a detector's sums, ray by ray. */

struct rmap_detector_hit {
    size_t cell;
    struct rmap_registration_place place;
    size_t segment; /* row of /segment */
};

/* A registration's flux spread over the three colour components, rounded to quanta: integers
 * add up the same in any order. */
static void add_colour(struct rmap_detector_sums *sums, const struct rmap_portion *portion,
                       const struct rmap_detector_hit *hit, double flux)
{
    const uint16_t *share = portion->colour + hit->segment * (size_t)portion->n_channel;
    double sum[3] = {0.0, 0.0, 0.0};
    for (int i = 0; i < portion->n_channel; i++)
        for (int k = 0; k < 3; k++)
            sum[k] += share[i] * sums->channel_colour[i][k];
    for (size_t k = 0; k < 3; k++)
        sums->colour[3 * hit->cell + k] += llround(sum[k] / 65535.0 * flux / sums->quantum);
}

/* Of a registration's light, the part of 65535 that channel c has; or how much of it is seen. */
static double share_of(const struct rmap_detector_sums *sums, const struct rmap_portion *portion,
                       const struct rmap_detector_hit *hit, size_t c)
{
    const uint16_t *share = portion->colour + hit->segment * (size_t)portion->n_channel;
    double seen = 0.0;
    if (c < sums->n_spectral)
        return share[c] == 0 || !sums->ask.weighed || sums->ask.xyz
                   ? share[c]
                   : share[c] / sums->seen_unit *
                         rmap_registration_response_to(sums->scene, portion, &hit->place, (int)c);
    if (c >= sums->n_spectral + sums->n_seen) {
        const size_t k = c - sums->n_spectral - sums->n_seen;
        for (int i = 0; i < portion->n_channel; i++)
            seen += share[i] * sums->channel_xyz[i][k];
        return seen / sums->xyz_unit;
    }
    if (sums->ask.weighed)
        return 65535.0 * rmap_registration_response(sums->scene, portion, &hit->place) /
               sums->seen_unit;
    for (int i = 0; i < portion->n_channel; i++)
        seen += share[i] * sums->channel_luminous[i];
    return seen;
}

/* Registrations of one ray in the same cell (or, cell n_cell, in any), channel by channel. */
static void add_shares(struct rmap_detector_sums *sums, const struct rmap_portion *portion,
                       const struct rmap_detector_hit *hit, size_t n_hit, size_t source,
                       size_t cell, double weight)
{
    const bool in_all = cell == sums->n_cell;
    for (size_t c = sums->ask.channels || in_all ? 0 : sums->n_spectral; c < sums->n_channel; c++) {
        double share = 0.0;
        for (size_t k = 0; k < n_hit; k++)
            share += share_of(sums, portion, &hit[k], c);
        if (share == 0.0)
            continue;
        const double q = weight * share;
        uint64_t *sum = sums->share + share_place(sums, source, c, cell);
        sum[0] += (uint64_t)llround(q * (RMAP_SHARE_UNIT / 65535.0));
        sum[sums->n_share / 2] += (uint64_t)llround(q * q);
    }
}

static int by_cell(const void *a, const void *b)
{
    const struct rmap_detector_hit *left = a, *right = b;
    if (left->cell != right->cell)
        return left->cell < right->cell ? -1 : 1;
    return (left->segment > right->segment) - (left->segment < right->segment);
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
        sum[sums->n_source * sums->n_cell] += rmap_weight_squared(q);
        if (sums->n_channel)
            add_shares(sums, portion, hit + first, last - first, source, hit[first].cell, weight);
        for (size_t k = first; k < last && sums->n_colour; k++)
            add_colour(sums, portion, &hit[k],
                       sums->ask.weighed && !sums->ask.bins.detector->response->lumens
                           ? flux * rmap_registration_response(sums->scene, portion, &hit[k].place)
                           : flux);
    }
    sums->total[source] += all;
    sums->total[sums->n_source + source] += rmap_weight_squared(all);
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
                                 const struct rmap_registration_place *place, uint32_t segment,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_RESERVE(sums->hit, sums->cap_hit, n_hit + 1, err);
    if (st != RMAP_OK)
        return st;
    sums->hit[n_hit] = (struct rmap_detector_hit){cell, *place, place->first_segment + segment};
    return RMAP_OK;
}

/* Registrations [row, end) of ray row `ray`, whose segments begin at row `segment`. */
static enum rmap_status add_ray(struct rmap_detector_sums *sums, const struct rmap_matched *rays,
                                size_t ray, size_t row, size_t end, size_t first,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *portion = rays->portion;
    const uint8_t *counts = rmap_registrations_counted(rays);
    size_t n_hit = 0;
    for (; row < end; row++) {
        if (portion->registration.detector[row] != sums->ask.detector || !counts[row])
            continue;
        const uint32_t segment = portion->registration.segment[row];
        const size_t cell = rmap_detector_bins_cell(&sums->ask.bins, portion, row);
        if (cell == SIZE_MAX - 1 || (uint32_t)portion->ray.source[ray] >= sums->n_source ||
            segment >= portion->ray.segment_count[ray])
            return rmap_error_set(
                err, RMAP_FORMAT,
                "damaged map: a ray of the block from ray %" PRIu64
                " on is registered where there is no cell, or on segment %u, which it "
                "has not",
                portion->first_ray, segment);
        if (cell == SIZE_MAX || is_off(sums, (size_t)portion->ray.source[ray]))
            continue;
        const struct rmap_registration_place place = {row, ray, first};
        RMAP_TRY(take_hit(sums, n_hit++, cell, &place, segment, err));
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
    sums->scene = (size_t)sums->ask.detector < scene->n_detector
                      ? scene
                      : rmap_scene_with(sums->ask.map, sums->ask.overlay);
    if (sums->ask.weighed && sums->scene->channels.n != scene->channels.n)
        return tell_other_channels(sums->ask.map, err);
    if (sums->n_colour)
        channel_colours_as(scene, first->channels.mode, sums->channel_colour);
    for (int i = 0; sums->ask.luminous && i < scene->channels.n; i++)
        sums->channel_luminous[i] = rmap_channel_luminous(&scene->channels, i) / sums->seen_unit;
    if (sums->n_xyz)
        (void)find_xyz(scene, sums->channel_xyz);
    if (sums->n_spectral && !same_channels(&scene->channels, &first->channels))
        return tell_other_channels(sums->ask.map, err);
    return RMAP_OK;
}

/* Adds what the detector registered of the rays, in the region. RMAP_FORMAT. */
static enum rmap_status detector_sums_add(void *state, const struct rmap_matched *rays,
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
