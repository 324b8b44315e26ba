/* SPDX-License-Identifier: MIT */
#include <string.h>

#include "base/alloc.h"
#include "compact/paths.h"
#include "compact/settle.h"

struct rmap_compact_decoder {
    const struct rmap_compact_model *model;
    struct rmap_lane lane[RMAP_LANE_COUNT];
    struct rmap_wave wave;
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
    if (decoder)
        rmap_wave_fini(&decoder->wave);
    rmap_free(decoder);
}

#define BIT(column) RMAP_COLUMN_BIT(column)

/* Columns that only the legs, traced again, tell. */
#define LEG_COLUMNS                                                                                \
    (BIT(RMAP_RAY_path_length) | BIT(RMAP_RAY_optical_path) | BIT(RMAP_RAY_start) |                \
     BIT(RMAP_RAY_start_normal) | BIT(RMAP_RAY_end_direction) | BIT(RMAP_SEGMENT_position) |       \
     BIT(RMAP_SEGMENT_normal) | BIT(RMAP_SEGMENT_colour) | CROSSING_LANES)

#define CROSSING_LANES                                                                             \
    (BIT(RMAP_REGISTRATION_cell) | BIT(RMAP_REGISTRATION_relative) |                               \
     BIT(RMAP_REGISTRATION_direction) | BIT(RMAP_REGISTRATION_optical_path))

#define COLOUR_COLUMNS                                                                             \
    (BIT(RMAP_SEGMENT_colour) | BIT(RMAP_RAY_optical_path) | BIT(RMAP_REGISTRATION_optical_path))

#define HEAD_COLUMNS                                                                               \
    (BIT(RMAP_RAY_source) | BIT(RMAP_RAY_stop) | BIT(RMAP_RAY_segment_count) |                     \
     BIT(RMAP_RAY_registration_count) | BIT(RMAP_RAY_start_object))

#define SIMPLE_COLUMNS                                                                             \
    (BIT(RMAP_RAY_id) | BIT(RMAP_RAY_weight) | BIT(RMAP_RAY_wavelength) |                          \
     BIT(RMAP_RAY_start_primitive) | BIT(RMAP_SEGMENT_primitive) | BIT(RMAP_SEGMENT_medium))

/* What must be decoded so that these columns can be. */
static rmap_column_set with_needs(rmap_column_set columns)
{
    if (columns & LEG_COLUMNS)
        columns |= BIT(RMAP_RAY_id) | BIT(RMAP_SEGMENT_primitive) | BIT(RMAP_SEGMENT_medium) |
                   HEAD_COLUMNS;
    if (columns & CROSSING_LANES)
        columns |= BIT(RMAP_REGISTRATION_segment) | BIT(RMAP_REGISTRATION_detector);
    if (columns & BIT(RMAP_SEGMENT_primitive))
        columns |= BIT(RMAP_SEGMENT_object);
    if (columns & BIT(RMAP_SEGMENT_medium))
        columns |= BIT(RMAP_SEGMENT_object) | BIT(RMAP_SEGMENT_event);
    return columns;
}

static enum rmap_status damaged(const char *what, struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_FORMAT, "damaged portion: %s", what);
}

/* Streams as typed rows. */
struct own {
    const uint32_t *path;
    const int32_t *source, *detector;
    const uint8_t *stop, *registered;
    const uint32_t *start_object, *segment_count, *registration_count, *object, *event, *segment;
};

static struct own own_rows(const struct rmap_rows *rows)
{
    void *const *data = rows->data;
    return (struct own){.path = data[RMAP_STREAM_ray_path],
                        .source = data[RMAP_STREAM_OWN_source],
                        .stop = data[RMAP_STREAM_OWN_stop],
                        .start_object = data[RMAP_STREAM_OWN_start_object],
                        .segment_count = data[RMAP_STREAM_OWN_segment_count],
                        .registration_count = data[RMAP_STREAM_OWN_registration_count],
                        .object = data[RMAP_STREAM_OWN_object],
                        .event = data[RMAP_STREAM_OWN_event],
                        .segment = data[RMAP_STREAM_OWN_segment],
                        .detector = data[RMAP_STREAM_OWN_detector],
                        .registered = data[RMAP_STREAM_OWN_registered]};
}

/* The streams are there, the paths exist, and their rows add up to what the index promises. */
static enum rmap_status check(const struct rmap_path_table *table, const struct rmap_rows *rows,
                              const size_t n_row[RMAP_TABLE_COUNT], uint64_t streams,
                              struct rmap_error *err)
{
    if (rows->layout != &rmap_compact_layout)
        return rmap_error_set(err, RMAP_INTERNAL, "rows are not of the compact encoding");
    for (int s = 0; s < RMAP_COMPACT_STREAM_COUNT; s++)
        if ((streams >> s & 1) && !rows->data[s] && rows->n_row[rows->layout->stream[s].table] > 0)
            return rmap_error_set(err, RMAP_INTERNAL, "no rows of %s",
                                  rows->layout->stream[s].path);
    if (rows->n_row[RMAP_COMPACT_RAY] != n_row[RMAP_TABLE_RAY])
        return damaged("it has not as many rays as the index says", err);
    if (rows->n_row[RMAP_COMPACT_CURVE] != n_row[RMAP_TABLE_CURVE])
        return damaged("it has not as many points of curved legs as the index says", err);
    const struct own own = own_rows(rows);
    size_t n_own = rows->n_row[RMAP_COMPACT_OWN], k = 0;
    uint64_t n[2] = {0, 0}, own_n[2] = {0, 0}; /* at most 2^32 rays of 2^32 rows */
    for (size_t i = 0; i < n_row[RMAP_TABLE_RAY]; i++) {
        uint32_t path = own.path[i];
        if (path > table->n || (path == 0 && k == n_own))
            return damaged("a ray refers to a path that is not there", err);
        if (path > 0) {
            n[0] += table->path[path - 1].n_segment;
            n[1] += table->path[path - 1].n_registration;
        } else {
            own_n[0] += own.segment_count[k];
            own_n[1] += own.registration_count[k++];
        }
        if (n[0] + own_n[0] > n_row[RMAP_TABLE_SEGMENT] ||
            n[1] + own_n[1] > n_row[RMAP_TABLE_REGISTRATION])
            break;
    }
    if (n[0] + own_n[0] != n_row[RMAP_TABLE_SEGMENT] ||
        n[1] + own_n[1] != n_row[RMAP_TABLE_REGISTRATION])
        return damaged("its paths have not as many rows as the index says", err);
    if (k != n_own || own_n[0] != rows->n_row[RMAP_COMPACT_OWN_SEGMENT] ||
        own_n[1] != rows->n_row[RMAP_COMPACT_OWN_REGISTRATION])
        return damaged("its own paths have not as many rows as there are", err);
    return RMAP_OK;
}

/* Sources, stops, counts. */
static void fill_heads(const struct rmap_path_table *table, const struct own *own,
                       rmap_column_set columns, struct rmap_portion *out)
{
    size_t k = 0;
    const struct rmap_ray_columns *ray = &out->ray;
    for (size_t i = 0; i < out->n_row[RMAP_TABLE_RAY]; i++) {
        struct rmap_known_path path;
        if (own->path[i] > 0) {
            path = table->path[own->path[i] - 1];
        } else {
            path = (struct rmap_known_path){.source = own->source[k],
                                            .stop = own->stop[k],
                                            .start_object = (int32_t)(own->start_object[k] - 1),
                                            .n_segment = own->segment_count[k],
                                            .n_registration = own->registration_count[k]};
            k++;
        }
        if (columns & BIT(RMAP_RAY_source))
            ray->source[i] = path.source;
        if (columns & BIT(RMAP_RAY_stop))
            ray->stop[i] = path.stop;
        if (columns & BIT(RMAP_RAY_start_object))
            ray->start_object[i] = path.start_object;
        if (columns & BIT(RMAP_RAY_segment_count))
            ray->segment_count[i] = path.n_segment;
        if (columns & BIT(RMAP_RAY_registration_count))
            ray->registration_count[i] = path.n_registration;
    }
}

static void fill_own_legs(const struct rmap_compact_model *model, const struct own *own, size_t k,
                          size_t from, size_t to, rmap_column_set columns, struct rmap_portion *out)
{
    struct rmap_segment_columns *segment = &out->segment;
    const struct rmap_folded_path path = {.source = own->source[k],
                                          .stop = own->stop[k],
                                          .n = own->segment_count[k],
                                          .object = own->object + from,
                                          .event = own->event + from};
    rmap_path_unfold(model, &path, columns & BIT(RMAP_SEGMENT_object) ? segment->object + to : NULL,
                     columns & BIT(RMAP_SEGMENT_event) ? segment->event + to : NULL,
                     columns & BIT(RMAP_SEGMENT_medium) ? segment->medium + to : NULL);
}

/* Known paths are copied by so many legs, into rows that are filled later, if there are as many. */
#define COPIED 8

static inline void copy_legs(void *to, const void *from, size_t n, size_t nbytes)
{
    uint8_t *out = to;
    const uint8_t *in = from;
    if (n % COPIED != 0)
        memcpy(out, in, n * nbytes);
    for (size_t i = 0; n % COPIED == 0 && i < n; i += COPIED)
        memcpy(out + i * nbytes, in + i * nbytes, COPIED * nbytes);
}

/* Objects, events, and media as the paths say. */
static void fill_legs(const struct rmap_compact_model *model, const struct rmap_path_table *table,
                      const struct own *own, rmap_column_set columns, struct rmap_portion *out)
{
    struct rmap_segment_columns *segment = &out->segment;
    size_t k = 0, from = 0, to = 0, n_row = out->n_row[RMAP_TABLE_SEGMENT];
    for (size_t i = 0; i < out->n_row[RMAP_TABLE_RAY]; i++) {
        if (own->path[i] == 0) {
            fill_own_legs(model, own, k, from, to, columns, out);
            from += own->segment_count[k];
            to += own->segment_count[k++];
            continue;
        }
        const struct rmap_known_path *path = &table->path[own->path[i] - 1];
        size_t n = path->n_segment, most = (n + COPIED - 1) / COPIED * COPIED;
        most = most <= n_row - to && most <= table->n_segment - path->segment ? most : n;
        if (columns & BIT(RMAP_SEGMENT_object))
            copy_legs(segment->object + to, table->object + path->segment, most, 4);
        if (columns & BIT(RMAP_SEGMENT_event))
            copy_legs(segment->event + to, table->event + path->segment, most, 4);
        if (columns & BIT(RMAP_SEGMENT_medium))
            copy_legs(segment->medium + to, table->medium + path->segment, most, 2);
        to += n;
    }
}

/* Rows [from, from + n) of a path, out of its own columns or the table's. */
struct crossings {
    const uint32_t *segment;
    const int32_t *detector;
    const uint8_t *registered;
};

static void fill_crossings(const struct rmap_path_table *table, const struct own *own,
                           rmap_column_set columns, struct rmap_portion *out)
{
    const struct crossings known = {table->segment, table->detector, table->registered},
                           rare = {own->segment, own->detector, own->registered};
    struct rmap_registration_columns *registration = &out->registration;
    size_t k = 0, own_from = 0, to = 0;
    for (size_t i = 0; i < out->n_row[RMAP_TABLE_RAY]; i++) {
        const struct crossings *c = &rare;
        size_t from = own_from, n;
        if (own->path[i] > 0) {
            c = &known;
            from = table->path[own->path[i] - 1].registration;
            n = table->path[own->path[i] - 1].n_registration;
        } else {
            n = own->registration_count[k++];
            own_from += n;
        }
        for (size_t j = 0; j < n; j++, to++) {
            if (columns & BIT(RMAP_REGISTRATION_segment))
                registration->segment[to] = c->segment[from + j];
            if (columns & BIT(RMAP_REGISTRATION_detector))
                registration->detector[to] = c->detector[from + j];
            if (columns & BIT(RMAP_REGISTRATION_registered))
                registration->registered[to] = c->registered[from + j];
        }
    }
}

/* Numbers that stand in the lane's column as predicted become the truth. */
static void correct(struct rmap_lane *lane)
{
    if (lane->next < lane->n)
        rmap_lane_amend(lane, 0, lane->n);
}

static enum rmap_status fill_primitives(const struct rmap_compact_model *model,
                                        struct rmap_lane *lane, const struct rmap_rows *rows,
                                        struct rmap_portion *out, struct rmap_error *err)
{
    const uint32_t *triangle = rows->data[RMAP_STREAM_triangle];
    size_t n = out->n_row[RMAP_TABLE_SEGMENT], n_triangle = rows->n_row[RMAP_COMPACT_TRIANGLE];
    size_t k = 0;
    for (size_t i = 0; i < n && n_triangle == 0; i++)
        out->segment.primitive[i] = out->segment.object[i] < 0 ? -1 : 0;
    for (size_t i = 0; i < n && n_triangle > 0; i++) {
        /* no branch: whether it is a mesh is anybody's guess */
        size_t object = (uint32_t)out->segment.object[i];
        uint32_t listed = model->body[object < model->n_object ? object : model->n_object].mesh;
        uint32_t plain = out->segment.object[i] < 0 ? UINT32_MAX : 0;
        uint32_t next = triangle[k < n_triangle ? k : 0];
        uint32_t primitive = plain ^ ((plain ^ next) & ((uint32_t)0 - listed));
        out->segment.primitive[i] = (int32_t)primitive;
        k += listed;
    }
    correct(lane);
    if (k > n_triangle)
        return damaged("it has too few triangles", err);
    return k == n_triangle ? RMAP_OK : damaged("it has too many triangles", err);
}

static void fill_ids(struct rmap_lane *lane, uint64_t first, size_t n, uint64_t *out)
{
    bool right = lane->next >= n;
    uint64_t id = first;
    for (size_t i = 0; i < n && right; i++)
        out[i] = first + i;
    for (size_t i = 0; i < n && !right; i++, id++)
        (void)rmap_lane_offer(lane, i, 1, sizeof id, &id);
}

/* Lanes that need no leg. */
static void fill_simple(struct rmap_compact_decoder *decoder, const struct rmap_rows *rows,
                        uint64_t first, rmap_column_set columns, struct rmap_portion *out)
{
    struct rmap_lane *lane = decoder->lane;
    const uint8_t *channel = rows->data[RMAP_STREAM_ray_channel];
    size_t n = out->n_row[RMAP_TABLE_RAY];
    if (columns & BIT(RMAP_RAY_id))
        fill_ids(&lane[RMAP_LANE_RAY_id], first, n, out->ray.id);
    for (size_t i = 0; i < n && (columns & BIT(RMAP_RAY_weight)); i++)
        out->ray.weight[i] = 1.0;
    for (size_t i = 0; i < n && (columns & BIT(RMAP_RAY_wavelength)); i++)
        out->ray.wavelength[i] = rmap_wavelength_of(decoder->model, channel[i]);
    for (size_t i = 0; i < n && (columns & BIT(RMAP_RAY_start_primitive)); i++)
        out->ray.start_primitive[i] = -1;
    if (columns & BIT(RMAP_RAY_weight))
        correct(&lane[RMAP_LANE_RAY_weight]);
    if (columns & BIT(RMAP_RAY_wavelength))
        correct(&lane[RMAP_LANE_RAY_wavelength]);
    if (columns & BIT(RMAP_RAY_start_primitive))
        correct(&lane[RMAP_LANE_RAY_start_primitive]);
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

static enum rmap_status retrace(struct rmap_compact_decoder *decoder, const struct rmap_rows *rows,
                                const uint64_t *header, rmap_column_set columns,
                                struct rmap_portion *out, struct rmap_error *err)
{
    bool crossings = columns & CROSSING_LANES;
    struct rmap_retrace r = {.model = decoder->model,
                             .seed = header[RMAP_HEADER_SEED],
                             .n_ray = out->n_row[RMAP_TABLE_RAY],
                             .id = out->ray.id,
                             .source = out->ray.source,
                             .stop = out->ray.stop,
                             .segment_count = out->ray.segment_count,
                             .registration_count = out->ray.registration_count,
                             .start_object = out->ray.start_object,
                             .channel = rows->data[RMAP_STREAM_ray_channel],
                             .object = out->segment.object,
                             .primitive = out->segment.primitive,
                             .event = out->segment.event,
                             .medium = out->segment.medium,
                             .crossing_segment = crossings ? out->registration.segment : NULL,
                             .crossing_detector = out->registration.detector,
                             .colour = (columns & COLOUR_COLUMNS) || decoder->model->absorbing,
                             .lane = decoder->lane};
    bool one_by_one = header[RMAP_HEADER_MODES] & RMAP_HEADER_ONE_BY_ONE;
    return rmap_settle_decode(&decoder->wave, &r, one_by_one, out, err);
}

static enum rmap_status fill_lanes(struct rmap_compact_decoder *decoder,
                                   const struct rmap_rows *rows, rmap_column_set columns,
                                   struct rmap_portion *out, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_lane *lane = decoder->lane;
    const struct rmap_lane_store store = {.pool16 = rows->data[RMAP_STREAM_pool16],
                                          .pool32 = rows->data[RMAP_STREAM_pool32],
                                          .pool64 = rows->data[RMAP_STREAM_pool64],
                                          .skip = rows->data[RMAP_STREAM_patch_skip],
                                          .value = rows->data[RMAP_STREAM_patch_value],
                                          .n16 = rows->n_row[RMAP_COMPACT_POOL16],
                                          .n32 = rows->n_row[RMAP_COMPACT_POOL32],
                                          .n64 = rows->n_row[RMAP_COMPACT_POOL64],
                                          .n_patch = rows->n_row[RMAP_COMPACT_PATCH]};
    RMAP_TRY(rmap_lanes_load(lane, &store, columns, out, err));
    out->first_ray = store.pool64[RMAP_HEADER_FIRST];
    fill_simple(decoder, rows, out->first_ray, columns, out);
    if (columns & BIT(RMAP_SEGMENT_primitive))
        RMAP_TRY(
            fill_primitives(decoder->model, &lane[RMAP_LANE_SEGMENT_primitive], rows, out, err));
    if (columns & BIT(RMAP_SEGMENT_medium))
        correct_media(&lane[RMAP_LANE_SEGMENT_medium], out);
    if (columns & LEG_COLUMNS)
        RMAP_TRY(retrace(decoder, rows, store.pool64, columns, out, err));
out:
    return st;
}

enum rmap_status rmap_compact_decode(struct rmap_compact_decoder *decoder,
                                     const struct rmap_path_table *table,
                                     const struct rmap_rows *rows,
                                     const size_t n_row[RMAP_TABLE_COUNT], rmap_column_set columns,
                                     struct rmap_portion *out, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint64_t streams = rmap_compact_streams(columns);
    rmap_portion_clear(out);
    if (out->n_channel != decoder->model->n_channel)
        return rmap_error_set(err, RMAP_INTERNAL, "a portion of %d channels in a scene of %d",
                              out->n_channel, decoder->model->n_channel);
    RMAP_TRY(check(table, rows, n_row, streams, err));
    columns = with_needs(columns);
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        RMAP_TRY(rmap_portion_reserve(out, (enum rmap_table)t, n_row[t], columns, err));
    memcpy(out->n_row, n_row, sizeof out->n_row);
    const struct own own = own_rows(rows);
    if (columns & HEAD_COLUMNS)
        fill_heads(table, &own, columns, out);
    if (columns & (BIT(RMAP_SEGMENT_object) | BIT(RMAP_SEGMENT_event)))
        fill_legs(decoder->model, table, &own, columns, out);
    if (columns & (BIT(RMAP_REGISTRATION_segment) | BIT(RMAP_REGISTRATION_detector) |
                   BIT(RMAP_REGISTRATION_registered)))
        fill_crossings(table, &own, columns, out);
    fill_curve(rows, columns, out);
    if (columns & (LEG_COLUMNS | SIMPLE_COLUMNS))
        RMAP_TRY(fill_lanes(decoder, rows, columns, out, err));
out:
    if (st != RMAP_OK)
        rmap_portion_clear(out);
    return st;
}
