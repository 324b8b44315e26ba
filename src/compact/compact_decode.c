/* SPDX-License-Identifier: MIT
 *
 * The compact encoding: rows of compact streams into the same portions, bit for bit.
 */
#include "compact/compact.h"

#include <string.h>

#include "base/alloc.h"
#include "compact/damaged.h"
#include "compact/decode_paths.h"
#include "compact/detect.h"
#include "compact/primitives.h"
#include "compact/settle.h"
#include "compact/unpredicted.h"

struct rmap_compact_decoder {
    const struct rmap_compact_model *model;
    struct rmap_lane lane[RMAP_LANE_COUNT];
    struct rmap_batch batch;
    struct rmap_step_buffer steps;       /* of own paths */
    const uint8_t *passed_over;          /* rays that are of no interest; NULL: none */
    struct rmap_unpredicted unpredicted; /* of the portion decoded last, where that is known */
};

enum rmap_status rmap_compact_decoder_create(const struct rmap_compact_model *model,
                                             struct rmap_compact_decoder **decoder_ret,
                                             struct rmap_error *err)
{
    struct rmap_compact_decoder *decoder = rmap_alloc(1, sizeof *decoder);
    if (!decoder)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a decoder");
    decoder->model = model;
    rmap_lanes_init(decoder->lane);
    *decoder_ret = decoder;
    return RMAP_OK;
}

void rmap_compact_decoder_destroy(struct rmap_compact_decoder *decoder)
{
    if (!decoder)
        return;
    rmap_batch_fini(&decoder->batch);
    rmap_free(decoder->steps.class);
    rmap_free(decoder);
}

void rmap_compact_decoder_pass_over(struct rmap_compact_decoder *decoder, const uint8_t *mark)
{
    decoder->passed_over = mark;
}

#define BIT(column) RMAP_COLUMN_BIT(column)

/* Columns that lanes have. */
#define LANE(column, role) | BIT(RMAP_##column)
#define LANE_COLUMNS       (RMAP_COLUMNS_ANGLES RMAP_LANES(LANE))

#define COLOUR_COLUMNS                                                                             \
    (BIT(RMAP_SEGMENT_colour) | BIT(RMAP_RAY_optical_path) | BIT(RMAP_REGISTRATION_optical_path) | \
     BIT(RMAP_RAY_group_path) | BIT(RMAP_REGISTRATION_group_path))

/* The streams are there. */
static enum rmap_status check_streams(const struct rmap_rows *rows, uint64_t streams,
                                      struct rmap_error *err)
{
    if (rows->layout != &rmap_compact_layout)
        return rmap_error_set(err, RMAP_INTERNAL, "rows are not of the compact encoding");
    for (int s = 0; s < RMAP_COMPACT_STREAM_COUNT; s++)
        if ((streams >> s & 1) && !rows->data[s] && rows->n_row[rows->layout->stream[s].table] > 0)
            return rmap_error_set(err, RMAP_INTERNAL, "no rows of %s",
                                  rows->layout->stream[s].path);
    return RMAP_OK;
}

static enum rmap_status fill_primitives(const struct rmap_compact_model *model,
                                        struct rmap_lane *lane, const struct rmap_rows *rows,
                                        struct rmap_portion *out, struct rmap_error *err)
{
    const uint32_t *triangle = rows->data[RMAP_STREAM_triangle];
    size_t n = out->n_row[RMAP_TABLE_SEGMENT], n_triangle = rows->n_row[RMAP_COMPACT_TRIANGLE];
    size_t k = rmap_primitives_place(model, out->segment.object, n, triangle, n_triangle,
                                     out->segment.primitive);
    rmap_lane_finish(lane);
    if (k > n_triangle)
        return rmap_portion_damaged("it has too few triangles", err);
    return k == n_triangle ? RMAP_OK : rmap_portion_damaged("it has too many triangles", err);
}

/* Lanes that need no segment. */
static void fill_simple(struct rmap_compact_decoder *decoder, const struct rmap_rows *rows,
                        uint64_t first, rmap_column_set columns, struct rmap_portion *out)
{
    struct rmap_lane *lane = decoder->lane;
    const uint8_t *channel = rows->data[RMAP_STREAM_ray_channel];
    size_t n = out->n_row[RMAP_TABLE_RAY];
    if (columns & BIT(RMAP_RAY_id))
        rmap_lane_fill_ids(&lane[RMAP_LANE_RAY_id], first, n, out->ray.id);
    for (size_t i = 0; i < n && (columns & BIT(RMAP_RAY_weight)); i++)
        out->ray.weight[i] = 1.0;
    for (size_t i = 0; i < n && (columns & BIT(RMAP_RAY_wavelength)); i++)
        out->ray.wavelength[i] = rmap_wavelength_of(decoder->model, channel[i]);
    for (size_t i = 0; i < n && (columns & BIT(RMAP_RAY_start_primitive)); i++)
        out->ray.start_primitive[i] = -1;
    if (columns & BIT(RMAP_RAY_weight))
        rmap_lane_finish(&lane[RMAP_LANE_RAY_weight]);
    if (columns & BIT(RMAP_RAY_wavelength))
        rmap_lane_finish(&lane[RMAP_LANE_RAY_wavelength]);
    if (columns & BIT(RMAP_RAY_start_primitive))
        rmap_lane_finish(&lane[RMAP_LANE_RAY_start_primitive]);
}

/* Media: what the paths say stands in the column; offered to itself it becomes the truth. */
static void correct_media(struct rmap_lane *lane, struct rmap_portion *out)
{
    int16_t *medium = out->segment.medium;
    size_t n = out->n_row[RMAP_TABLE_SEGMENT];
    lane->to = NULL;
    (void)rmap_lane_offer(lane, 0, n, sizeof *medium, medium);
}

/* They stand as they are. */
static void fill_curve(const struct rmap_rows *rows, rmap_column_set columns,
                       struct rmap_portion *out)
{
    size_t n = out->n_row[RMAP_TABLE_CURVE];
#define FILL(field, path, type, element, width, unit, text)                                        \
    if (n > 0 && (columns & BIT(RMAP_CURVE_##field)))                                              \
        memcpy(out->curve.field, rows->data[RMAP_STREAM_curve_##field], n *(width) * sizeof(type));
    RMAP_CURVE_COLUMNS(FILL)
#undef FILL
}

/* What detectors recorded of a place: as it stands, and its cells. */
static void fill_places(struct rmap_compact_decoder *decoder, rmap_column_set columns,
                        struct rmap_portion *out)
{
    struct rmap_lane *lane = decoder->lane;
    const struct rmap_registration_columns *hit = &out->registration;
    const size_t n = out->n_row[RMAP_TABLE_REGISTRATION];
    if (columns & BIT(RMAP_REGISTRATION_relative))
        rmap_lane_finish(&lane[RMAP_LANE_REGISTRATION_relative]);
    if (!(columns & BIT(RMAP_REGISTRATION_cell)))
        return;
    for (size_t i = 0; i < n; i++)
        rmap_detect_cell(decoder->model, hit->detector[i], hit->relative + 2 * i,
                         hit->cell + 2 * i);
    rmap_lane_finish(&lane[RMAP_LANE_REGISTRATION_cell]);
}

/* About the angles of registrations, where the portion says them. */
static enum rmap_status fill_angles(const struct rmap_lane_header *header, struct rmap_portion *out,
                                    struct rmap_error *err)
{
    const size_t n = out->n_row[RMAP_TABLE_REGISTRATION];
    const bool known = header->angles.degrees != NULL;
    const enum rmap_status st = known ? RMAP_RESERVE(out->angle, out->angle_cap, n, err) : RMAP_OK;
    out->knows_angles = known && st == RMAP_OK;
    if (out->knows_angles)
        rmap_angles_unpack(&header->angles, n, out->angle);
    return st;
}

static enum rmap_status retrace_rows(struct rmap_compact_decoder *decoder,
                                     const struct rmap_rows *rows,
                                     const struct rmap_lane_header *header, rmap_column_set traced,
                                     struct rmap_portion *out, struct rmap_error *err)
{
    struct rmap_retrace r = rmap_retrace_of(decoder->model, header, out,
                                            rows->data[RMAP_STREAM_ray_channel], decoder->lane);
    if (!(traced & RMAP_CROSSING_LANES))
        r.crossing_segment = NULL;
    else if (!(traced & ~RMAP_CROSSING_LANES))
        r.reach =
            traced & ~BIT(RMAP_REGISTRATION_direction) ? RMAP_REACH_CROSSING : RMAP_REACH_DIRECTION;
    r.passed_over = header->placed ? decoder->passed_over : NULL; /* cells are checked */
    r.colour = (traced & COLOUR_COLUMNS) || decoder->model->participating;
    struct rmap_portion made = *out; /* columns that are there stay */
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (rmap_compact_traced(header->placed) & ~traced & RMAP_COLUMN_BIT(c))
            *rmap_portion_column_address(&made, (enum rmap_column)c) = NULL;
    return rmap_settle_decode(&decoder->batch, &r, header->one_by_one, &made, err);
}

static enum rmap_status fill_lanes(struct rmap_compact_decoder *decoder,
                                   const struct rmap_rows *rows, rmap_column_set columns,
                                   rmap_column_set traced, struct rmap_portion *out,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_lane *lane = decoder->lane;
    struct rmap_lane_header header;
    const struct rmap_lane_store store = rmap_lane_store_of(rows);
    const rmap_column_set used = traced ? RMAP_COLUMNS_ALL : columns;
    RMAP_TRY(rmap_lanes_load(lane, &store, columns, used, out, &header, err));
    out->first_ray = header.first_ray;
    if (traced == (rmap_compact_traced(header.placed) & rmap_columns_of_run(out->timed)) &&
        rmap_unpredicted_list(decoder->model, lane, &header, out, &decoder->unpredicted))
        out->unpredicted = &decoder->unpredicted;
    fill_simple(decoder, rows, out->first_ray, columns, out);
    if (columns & BIT(RMAP_SEGMENT_primitive))
        RMAP_TRY(
            fill_primitives(decoder->model, &lane[RMAP_LANE_SEGMENT_primitive], rows, out, err));
    if (columns & BIT(RMAP_SEGMENT_medium))
        correct_media(&lane[RMAP_LANE_SEGMENT_medium], out);
    if (header.placed)
        fill_places(decoder, columns, out);
    if (columns & RMAP_COLUMNS_ANGLES)
        RMAP_TRY(fill_angles(&header, out, err));
    if (traced)
        RMAP_TRY(retrace_rows(decoder, rows, &header, traced, out, err));
out:
    return st;
}

/* Of columns that are to be decoded, what must be made, where some are there. Media are written
 * with what they follow from. */
static rmap_column_set without_present(rmap_column_set columns, rmap_column_set present,
                                       bool placed)
{
    const rmap_column_set wanted = rmap_compact_needs(columns & ~present, placed);
    const rmap_column_set again = wanted & ~present & BIT(RMAP_SEGMENT_medium)
                                      ? BIT(RMAP_SEGMENT_object) | BIT(RMAP_SEGMENT_event)
                                      : 0;
    return wanted & (~present | again);
}

static enum rmap_status fill(struct rmap_compact_decoder *decoder,
                             const struct rmap_path_table *table, const struct rmap_rows *rows,
                             const size_t n_row[RMAP_TABLE_COUNT], rmap_column_set columns,
                             const struct rmap_compact_summary *summary, struct rmap_portion *out,
                             struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const rmap_column_set traced = columns & rmap_compact_traced(summary->placed);
    const struct rmap_own_paths own = rmap_own_paths(decoder->model, table, rows, summary->classed);
    for (int t = 0; t < RMAP_TABLE_COUNT; t++) {
        out->n_row[t] = 0;
        RMAP_TRY(rmap_portion_reserve(out, (enum rmap_table)t, n_row[t], columns, err));
        out->n_row[t] = n_row[t];
    }
    rmap_paths_fill(&own, columns, out);
    fill_curve(rows, columns, out);
    if (columns & LANE_COLUMNS)
        st = fill_lanes(decoder, rows, columns, traced, out, err);
out:
    return st;
}

enum rmap_status rmap_compact_decode(struct rmap_compact_decoder *decoder,
                                     const struct rmap_path_table *table,
                                     const struct rmap_rows *stored,
                                     const size_t n_row[RMAP_TABLE_COUNT], rmap_column_set columns,
                                     rmap_column_set present, struct rmap_portion *out,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (!present)
        rmap_portion_clear(out);
    out->timed = decoder->model->scene->timed;
    columns &= rmap_columns_known(out->timed);
    if (out->n_channel != decoder->model->n_channel)
        return rmap_error_set(err, RMAP_INTERNAL, "a portion of %d channels in a scene of %d",
                              out->n_channel, decoder->model->n_channel);
    struct rmap_compact_summary summary;
    struct rmap_rows unpacked, *const rows = &unpacked;
    RMAP_TRY(check_streams(stored, rmap_compact_header_streams(), err));
    RMAP_TRY(rmap_compact_summarise_header(stored, &summary, err));
    RMAP_TRY(check_streams(stored, rmap_compact_streams(columns & ~present, &summary), err));
    RMAP_TRY(rmap_step_codes_unpack(stored, summary.n_code, &decoder->steps, &unpacked, err));
    if (rows->n_row[RMAP_COMPACT_RAY] != n_row[RMAP_TABLE_RAY])
        return rmap_portion_damaged("it has not as many rays as the index says", err);
    if (rows->n_row[RMAP_COMPACT_CURVE] != n_row[RMAP_TABLE_CURVE])
        return rmap_portion_damaged(
            "it has not as many points of curved segments as the index says", err);
    if (!rows->add_up) {
        const struct rmap_own_paths own =
            rmap_own_paths(decoder->model, table, rows, summary.classed);
        RMAP_TRY(rmap_own_paths_check(&own, n_row, err));
    }
    st = fill(decoder, table, rows, n_row, without_present(columns, present, summary.placed),
              &summary, out, err);
out:
    if (st != RMAP_OK)
        rmap_portion_clear(out);
    return st;
}
