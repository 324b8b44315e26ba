/* SPDX-License-Identifier: MIT */
#include "analysis/detector_sums.h"

#include <inttypes.h>
#include <math.h>

#include "analysis/query_marker.h"
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
    const struct rmap_scene *scene = rmap_map_scene(map);
    const uint32_t *cells = scene->detector[detector].cells;
    *sums = (struct rmap_detector_sums){
        .detector = detector, .n_source = scene->n_source, .n_cell = (size_t)cells[0] * cells[1]};
    sums->n_weight = 2 * sums->n_source * sums->n_cell;
    sums->n_colour = colour ? 3 * sums->n_cell : 0;
    double flux = 0.0;
    for (size_t s = 0; s < scene->n_source; s++)
        flux += scene->source[s].flux;
    sums->quantum = flux > 0.0 ? flux / QUANTA : 1.0;
    sums->weight = rmap_alloc(sums->n_weight, sizeof *sums->weight);
    sums->colour = colour ? rmap_alloc(sums->n_colour, sizeof *sums->colour) : NULL;
    if (sums->weight && (sums->colour || !colour))
        return RMAP_OK;
    rmap_detector_sums_fini(sums);
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a detector of %u x %u cells",
                          cells[0], cells[1]);
}

void rmap_detector_sums_fini(struct rmap_detector_sums *sums)
{
    rmap_free(sums->weight);
    rmap_free(sums->colour);
    *sums = (struct rmap_detector_sums){0};
}

void rmap_detector_sums_add_tally(struct rmap_detector_sums *sums, const struct rmap_tally *tally)
{
    for (size_t s = 0; s < sums->n_source; s++) {
        const double *image = rmap_tally_image(tally, (size_t)sums->detector, s);
        const double *squared = tally->image_squared + (image - tally->image);
        double *weight = sums->weight + s * sums->n_cell;
        for (size_t c = 0; c < sums->n_cell; c++) {
            weight[c] += image[c];
            weight[c + sums->n_source * sums->n_cell] += squared[c];
        }
    }
}

void rmap_detector_sums_merge(struct rmap_detector_sums *into,
                              const struct rmap_detector_sums *from)
{
    for (size_t i = 0; i < into->n_weight; i++)
        into->weight[i] += from->weight[i];
    for (size_t i = 0; i < into->n_colour; i++)
        into->colour[i] += from->colour[i];
}

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

struct scan {
    struct rmap_detector_sums *sums;
    const struct rmap_map *map;
    uint32_t width;
    int32_t space; /* of the colours; -1: none yet */
    double colour[RMAP_CHANNEL_MAX][3];
};

/* A registration's flux spread over the three colour components, rounded to quanta: integers
 * add up the same in any order. */
static void add_colour(struct scan *scan, const uint16_t *share, int n_channel, double flux,
                       size_t cell)
{
    double sum[3] = {0.0, 0.0, 0.0};
    for (int i = 0; i < n_channel; i++)
        for (int k = 0; k < 3; k++)
            sum[k] += share[i] * scan->colour[i][k];
    for (size_t k = 0; k < 3; k++)
        scan->sums->colour[3 * cell + k] += llround(sum[k] / 65535.0 * flux / scan->sums->quantum);
}

/* Row `row` of /registration, of ray row `ray`, whose legs begin at row `segment`. */
static enum rmap_status add_registration(struct scan *scan, const struct rmap_portion *portion,
                                         size_t ray, size_t row, size_t segment,
                                         struct rmap_error *err)
{
    struct rmap_detector_sums *sums = scan->sums;
    const uint16_t *at = portion->registration.cell + 2 * row;
    size_t cell = at[0] + (size_t)at[1] * scan->width;
    size_t source = (size_t)portion->ray.source[ray];
    size_t leg = segment + portion->registration.segment[row];
    if (at[0] >= scan->width || cell >= sums->n_cell || source >= sums->n_source ||
        leg >= segment + portion->ray.segment_count[ray])
        return rmap_error_set(err, RMAP_FORMAT,
                              "damaged map: ray %" PRIu64 " is registered in cell %u %u on leg %zu",
                              portion->ray.id[ray], at[0], at[1], leg - segment);
    double weight = portion->ray.weight[ray];
    double *sum = sums->weight + source * sums->n_cell + cell;
    sum[0] += weight;
    sum[sums->n_source * sums->n_cell] += weight * weight;
    if (sums->n_colour)
        add_colour(scan, portion->colour + leg * (size_t)portion->n_channel, portion->n_channel,
                   weight * rmap_map_flux_per_weight(scan->map)[source], cell);
    return RMAP_OK;
}

static enum rmap_status add_portion(struct scan *scan, const struct rmap_portion *portion,
                                    const uint8_t *match, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t row = 0, segment = 0;
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_RAY]; i++) {
        size_t end = row + portion->ray.registration_count[i];
        for (; row < end; row++)
            if ((!match || match[i]) && portion->registration.registered[row] &&
                portion->registration.detector[row] == scan->sums->detector)
                RMAP_TRY(add_registration(scan, portion, i, row, segment, err));
        segment += portion->ray.segment_count[i];
    }
out:
    return st;
}

static rmap_column_set columns_needed(bool colour)
{
    rmap_column_set columns =
        RMAP_COLUMN_BIT(RMAP_RAY_id) | RMAP_COLUMN_BIT(RMAP_RAY_source) |
        RMAP_COLUMN_BIT(RMAP_RAY_weight) | RMAP_COLUMN_BIT(RMAP_RAY_segment_count) |
        RMAP_COLUMN_BIT(RMAP_RAY_registration_count) | RMAP_COLUMN_BIT(RMAP_REGISTRATION_segment) |
        RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector) | RMAP_COLUMN_BIT(RMAP_REGISTRATION_cell) |
        RMAP_COLUMN_BIT(RMAP_REGISTRATION_registered);
    return colour ? columns | RMAP_COLUMN_BIT(RMAP_SEGMENT_colour) : columns;
}

/* What finds the rays of a portion that count. */
struct choice {
    struct rmap_query_marker *marker; /* NULL: all of them */
    uint8_t *match;                   /* the marker's */
};

static enum rmap_status choose(struct choice *choice, size_t portion, bool *any_ret,
                               struct rmap_error *err)
{
    size_t n = 0;
    *any_ret = true;
    if (!choice->marker)
        return RMAP_OK;
    enum rmap_status st = rmap_query_marker_mark(choice->marker, portion, &choice->match, &n, err);
    *any_ret = n > 0;
    return st;
}

enum rmap_status rmap_detector_sums_scan(struct rmap_detector_sums *sums,
                                         const struct rmap_map *map,
                                         const struct rmap_criterion *criterion, size_t first,
                                         size_t last, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_cursor *cursor = NULL;
    struct choice choice = {0};
    const struct rmap_scene *scene = rmap_map_scene(map);
    struct scan scan = {
        .sums = sums, .map = map, .width = scene->detector[sums->detector].cells[0], .space = -1};
    RMAP_TRY(rmap_cursor_create(map, columns_needed(sums->n_colour > 0), &cursor, err));
    if (criterion)
        RMAP_TRY(rmap_query_marker_create(map, criterion, &choice.marker, err));
    for (size_t i = first; i < last; i++) {
        const struct rmap_portion_info *info = rmap_map_portion(map, i);
        const struct rmap_portion *portion = NULL;
        bool any = (info->summary.detectors >> (sums->detector % 64) & 1) != 0;
        if (any)
            RMAP_TRY(choose(&choice, i, &any, err));
        if (!any)
            continue;
        RMAP_TRY(rmap_cursor_read(cursor, i, &portion, err));
        if (info->space != scan.space)
            channel_colours_as(rmap_map_scene_of(map, (size_t)info->space), scene->channels.mode,
                               scan.colour);
        scan.space = info->space;
        RMAP_TRY(add_portion(&scan, portion, choice.match, err));
    }
out:
    rmap_query_marker_destroy(choice.marker);
    rmap_cursor_destroy(cursor);
    return st;
}
