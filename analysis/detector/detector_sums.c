/* SPDX-License-Identifier: MIT */
#include "analysis/detector/detector_sums.h"

#include <string.h>

#include "analysis/query/fold_blocks.h"
#include "base/alloc.h"
#include "optics/spectrum.h"
#include "trace/tally.h"

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

double rmap_channel_luminous(const struct rmap_channels *channels, int channel)
{
    double alone[RMAP_CHANNEL_MAX] = {0.0};
    alone[channel] = 1.0;
    return rmap_luminous_efficacy(channels, alone);
}

double rmap_luminous_most(const struct rmap_channels *channels)
{
    double most = 0.0;
    for (int i = 0; i < channels->n; i++)
        most = fmax(most, rmap_channel_luminous(channels, i));
    return most > 0.0 ? most : 1.0;
}

/* The arrays of sums, for those who copy them as bytes. */
enum { BLOCKS = 5 };
static void blocks_of(const struct rmap_detector_sums *sums, struct rmap_fold_block block[BLOCKS])
{
    block[0] = (struct rmap_fold_block){sums->weight, sums->n_weight * sizeof *sums->weight};
    block[1] = (struct rmap_fold_block){sums->total, 2 * sums->n_source * sizeof *sums->total};
    block[2] = (struct rmap_fold_block){sums->colour, sums->n_colour * sizeof *sums->colour};
    block[3] = (struct rmap_fold_block){sums->share, sums->n_share * sizeof *sums->share};
    block[4] = (struct rmap_fold_block){
        sums->centre, sums->centre ? 4 * sums->n_source * sizeof *sums->centre : 0};
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
    sums->n_channel = ask->luminous ? 1 : ask->channels ? (size_t)scene->channels.n : 0;
    sums->luminous_unit = ask->luminous ? rmap_luminous_most(&scene->channels) : 0.0;
    sums->n_share = 2 * sums->n_source * sums->n_channel * (sums->n_cell + 1);
    double flux = 0.0;
    for (size_t s = 0; s < scene->n_source; s++)
        flux += scene->source[s].flux;
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

void rmap_detector_sums_add_tally(struct rmap_detector_sums *sums, const struct rmap_tally *tally)
{
    for (size_t s = 0; s < sums->n_source; s++) {
        const double *image = rmap_tally_image(tally, (size_t)sums->ask.detector, s);
        const double *squared = tally->image_squared + (image - tally->image);
        double *weight = sums->weight + s * sums->n_cell;
        for (size_t c = 0; c < sums->n_cell; c++) {
            weight[c] += image[c];
            weight[c + sums->n_source * sums->n_cell] += squared[c];
            sums->total[s] += image[c];
            sums->total[sums->n_source + s] += squared[c];
        }
    }
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

static enum rmap_status pack(const void *state, uint8_t **bytes_ret, size_t *nbytes_ret,
                             struct rmap_error *err)
{
    struct rmap_fold_block block[BLOCKS];
    blocks_of(state, block);
    return rmap_fold_pack(block, BLOCKS, bytes_ret, nbytes_ret, err);
}

static enum rmap_status unpack(const void *context, const uint8_t *bytes, size_t nbytes,
                               void **state_ret, struct rmap_error *err)
{
    struct rmap_fold_block block[BLOCKS];
    enum rmap_status st = create(context, state_ret, err);
    if (st != RMAP_OK)
        return st;
    blocks_of(*state_ret, block);
    return rmap_fold_unpack(block, BLOCKS, bytes, nbytes, err);
}

static bool may_count(const void *context, const struct rmap_portion_info *portion)
{
    const struct rmap_detector_ask *ask = context;
    return (portion->summary.detectors >> (ask->detector % 64) & 1) != 0;
}

rmap_column_set rmap_detector_sums_columns(const struct rmap_detector_ask *ask)
{
    rmap_column_set columns =
        RMAP_COLUMN_BIT(RMAP_RAY_id) | RMAP_COLUMN_BIT(RMAP_RAY_source) |
        RMAP_COLUMN_BIT(RMAP_RAY_weight) | RMAP_COLUMN_BIT(RMAP_RAY_segment_count) |
        RMAP_COLUMN_BIT(RMAP_RAY_registration_count) | RMAP_COLUMN_BIT(RMAP_REGISTRATION_segment) |
        RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector) |
        RMAP_COLUMN_BIT(RMAP_REGISTRATION_registered) | rmap_detector_bins_columns(&ask->bins);
    if (ask->centre)
        columns |= RMAP_COLUMN_BIT(RMAP_REGISTRATION_relative);
    if (ask->colour || ask->channels || ask->luminous)
        columns |= RMAP_COLUMN_BIT(RMAP_SEGMENT_colour);
    return columns;
}

const struct rmap_fold_kind rmap_detector_sums_kind = {.create = create,
                                                       .destroy = destroy,
                                                       .add = rmap_detector_sums_add,
                                                       .merge = merge,
                                                       .pack = pack,
                                                       .unpack = unpack,
                                                       .may_count = may_count};
