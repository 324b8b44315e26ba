/* SPDX-License-Identifier: MIT
 *
 * The streams of the compact encoding, once; behind them come the columns of /curve as they are.
 */
#include "compact/streams.h"

#include "compact/compact.h"
#include "compact/decode_paths.h"
#include "compact/lane_header.h"

static const char *const table_path[] = {
#define PATH(name, path) path,
    RMAP_COMPACT_TABLES(PATH)
#undef PATH
};

static const struct rmap_stream_info stream[] = {
#define INFO(name, table, path, element, text)                                                     \
    {RMAP_COMPACT_##table, path, RMAP_##element, 1, RMAP_UNIT_ONE, text},
    RMAP_COMPACT_STREAMS(INFO)
#undef INFO
#define INFO(field, path, type, element, width, unit, text)                                        \
    {RMAP_COMPACT_CURVE, path, RMAP_##element, width, RMAP_UNIT_##unit, text},
        RMAP_CURVE_COLUMNS(INFO)
#undef INFO
};

_Static_assert((int)RMAP_COMPACT_TABLE_COUNT <= RMAP_STORED_TABLE_MAX, "tables");
_Static_assert((int)RMAP_COMPACT_STREAM_COUNT <= RMAP_STREAM_MAX, "streams");
_Static_assert((int)RMAP_COMPACT_CURVE == RMAP_STORED_TABLE_STRAIGHT, "/curve comes last");

const struct rmap_layout rmap_compact_layout = {
    .encoding = RMAP_ENCODING_COMPACT,
    .n_table = RMAP_COMPACT_TABLE_COUNT,
    .table_path = table_path,
    .n_stream = RMAP_COMPACT_STREAM_COUNT,
    .stream = stream,
    .whole_tables = 1u << RMAP_COMPACT_PATH | 1u << RMAP_COMPACT_PATH_SEGMENT |
                    1u << RMAP_COMPACT_PATH_REGISTRATION,
    .run_tables = 1u << RMAP_COMPACT_RAY | 1u << RMAP_COMPACT_OWN | 1u << RMAP_COMPACT_OWN_SEGMENT |
                  1u << RMAP_COMPACT_OWN_REGISTRATION | 1u << RMAP_COMPACT_TRIANGLE |
                  1u << RMAP_COMPACT_POOL32,
    .quick_streams = UINT64_C(1) << RMAP_STREAM_OWN_object,
    .curve_table = RMAP_COMPACT_CURVE,
    .curve_stream = RMAP_STREAM_curve_ray,
    .time_stream = RMAP_COMPACT_STREAM_COUNT,
};

#define BIT(name) (UINT64_C(1) << RMAP_STREAM_##name)

/* Columns that a path says by itself. */
#define PATH_COLUMNS                                                                               \
    (RMAP_HEAD_COLUMNS | RMAP_CROSSING_COLUMNS | RMAP_COLUMN_BIT(RMAP_SEGMENT_object) |            \
     RMAP_COLUMN_BIT(RMAP_SEGMENT_event))

#define COLUMN(column) RMAP_COLUMN_BIT(RMAP_##column)

rmap_column_set rmap_compact_traced(bool placed)
{
#define TRACED(column, role)                                                                       \
    | (RMAP_LANE_##role != RMAP_LANE_SIMPLE && !(placed && RMAP_LANE_##role == RMAP_LANE_PLACED)   \
           ? COLUMN(column)                                                                        \
           : 0)
    return 0 RMAP_LANES(TRACED);
#undef TRACED
}

rmap_column_set rmap_compact_needs(rmap_column_set columns, bool placed)
{
    const rmap_column_set traced = columns & rmap_compact_traced(placed);
    if (traced)
        columns |=
            COLUMN(RAY_id) | COLUMN(SEGMENT_primitive) | COLUMN(SEGMENT_medium) | RMAP_HEAD_COLUMNS;
    if (traced & RMAP_CROSSING_LANES)
        columns |= COLUMN(REGISTRATION_segment) | COLUMN(REGISTRATION_detector);
    if (placed && (columns & COLUMN(REGISTRATION_cell)))
        columns |= COLUMN(REGISTRATION_relative) | COLUMN(REGISTRATION_detector);
    if (columns & COLUMN(SEGMENT_primitive))
        columns |= COLUMN(SEGMENT_object);
    if (columns & COLUMN(SEGMENT_medium))
        columns |= COLUMN(SEGMENT_object) | COLUMN(SEGMENT_event);
    return columns;
}

/* Those of lanes that need no segment. */
static uint64_t lane_streams(rmap_column_set columns)
{
    const uint64_t pool[9] = {[2] = BIT(pool16), [4] = BIT(pool32), [8] = 0};
    const rmap_column_set lanes = columns & ~(PATH_COLUMNS | RMAP_COLUMNS_CURVE);
    uint64_t streams = 0;
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (lanes & RMAP_COLUMN_BIT(c))
            streams |= pool[rmap_element_nbytes(rmap_column_info((enum rmap_column)c)->element)];
    if (lanes & RMAP_COLUMNS_ANGLES)
        streams |= BIT(pool16) | BIT(pool32);
    if (lanes & ~(COLUMN(REGISTRATION_relative) | RMAP_COLUMNS_ANGLES)) /* these have no patches */
        streams |= BIT(patch_skip) | BIT(patch_value);
    if (lanes & COLUMN(RAY_wavelength))
        streams |= BIT(ray_channel);
    if (lanes & COLUMN(SEGMENT_primitive))
        streams |= BIT(triangle);
    return streams;
}

uint64_t rmap_compact_streams(rmap_column_set columns, const struct rmap_compact_summary *header)
{
    const bool placed = header && header->placed;
    const rmap_column_set needs = rmap_compact_needs(columns, placed);
    uint64_t streams = BIT(ray_path) | BIT(OWN_segment_count) | BIT(OWN_registration_count) |
                       rmap_compact_header_streams() | lane_streams(needs);
    const bool traced = (needs & rmap_compact_traced(placed)) != 0;
    const bool steps = traced || (needs & (COLUMN(SEGMENT_object) | COLUMN(SEGMENT_event)));
    const bool folded = steps && !(header && header->classed);
    streams |= steps ? BIT(OWN_object) : 0;
    streams |= folded ? BIT(OWN_event) : 0;
    streams |= folded || (needs & COLUMN(RAY_source)) ? BIT(OWN_source) : 0;
    streams |= folded || (needs & COLUMN(RAY_stop)) ? BIT(OWN_stop) : 0;
    streams |= needs & COLUMN(RAY_start_object) ? BIT(OWN_start_object) : 0;
    streams |= traced || (needs & COLUMN(REGISTRATION_segment)) ? BIT(OWN_segment) : 0;
    streams |= traced || (needs & COLUMN(REGISTRATION_detector)) ? BIT(OWN_detector) : 0;
    streams |= traced || (needs & COLUMN(REGISTRATION_registered)) ? BIT(OWN_registered) : 0;
    if (traced)
        streams |= BIT(ray_channel) | BIT(triangle) | BIT(patch_skip) | BIT(patch_value) |
                   BIT(pool16) | BIT(pool32) | BIT(pool64);
#define CURVE(field, path, type, element, width, unit, text)                                       \
    if (columns & RMAP_COLUMN_BIT(RMAP_CURVE_##field))                                             \
        streams |= BIT(curve_##field);
    RMAP_CURVE_COLUMNS(CURVE)
#undef CURVE
    return streams;
}

bool rmap_compact_needs_rows(rmap_column_set columns)
{
    return columns & ~(RMAP_HEAD_COLUMNS | COLUMN(RAY_id) | COLUMN(RAY_weight));
}

uint64_t rmap_compact_header_streams(void)
{
    return BIT(pool64);
}

uint64_t rmap_compact_summary_streams(bool own_alone)
{
    return rmap_compact_header_streams() | BIT(OWN_segment_count) |
           (own_alone ? 0 : BIT(ray_path) | BIT(OWN_registration_count));
}

uint64_t rmap_compact_own_streams(rmap_column_set columns,
                                  const struct rmap_compact_summary *header)
{
    uint64_t streams = rmap_compact_streams(columns & RMAP_COLUMNS_DISCRETE, header);
    if (!(columns & COLUMN(RAY_id)))
        streams &= ~BIT(ray_path);
    if (!(columns & COLUMN(RAY_registration_count)))
        streams &= ~BIT(OWN_registration_count);
    return streams;
}

uint64_t rmap_compact_class_streams(void)
{
    return BIT(OWN_object) | BIT(OWN_segment_count);
}
