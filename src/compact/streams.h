/* SPDX-License-Identifier: MIT
 *
 * The streams of the compact encoding, once; behind them come the columns of /curve as they are.
 * X(name, table, dataset, element, description)
 */
#ifndef RMAP_COMPACT_STREAMS_H
#define RMAP_COMPACT_STREAMS_H

#include "compact/layout.h"

struct rmap_compact_summary;

/* clang-format off */
#define RMAP_COMPACT_TABLES(X)                                                                     \
    X(RAY, "/ray") X(OWN, "/own") X(OWN_SEGMENT, "/own_segment")                                   \
    X(OWN_REGISTRATION, "/own_registration") X(PATH, "/path") X(PATH_SEGMENT, "/path_segment")     \
    X(PATH_REGISTRATION, "/path_registration") X(TRIANGLE, "/triangle") X(PATCH, "/patch")         \
    X(POOL16, "/pool16") X(POOL32, "/pool32") X(POOL64, "/pool64") X(CURVE, "/curve")

#define RMAP_COMPACT_PATH(X, table, group)                                                         \
    X(table##_source, table, group "/source", I32, "source of the rays")                           \
    X(table##_stop, table, group "/stop", U8, "why they ended, as /ray/stop")                      \
    X(table##_start_object, table, group "/start_object", U32, "object emitted from + 1; 0: none") \
    X(table##_segment_count, table, group "/segment_count", U32, "rows of this path in " group "_segment") \
    X(table##_registration_count, table, group "/registration_count", U32, "rows of this path in " group "_registration") \
    X(table##_object, table##_SEGMENT, group "_segment/object", U32, "object met + 1, 0 and the one expected swapped")    \
    X(table##_event, table##_SEGMENT, group "_segment/event", U32, "event bits, exclusive or with those expected") \
    X(table##_segment, table##_REGISTRATION, group "_registration/segment", U32, "leg, from 0 within the ray") \
    X(table##_detector, table##_REGISTRATION, group "_registration/detector", I32, "index in /name/detector") \
    X(table##_registered, table##_REGISTRATION, group "_registration/registered", U8, "1 registered, 0 only crossed")

#define RMAP_COMPACT_STREAMS(X)                                                                    \
    X(ray_path, RAY, "/ray/path", U32, "1 + row in /path; 0: the next row of /own")                \
    X(ray_channel, RAY, "/ray/channel", U8, "1 + channel of the wavelength at the end; 0: none")   \
    RMAP_COMPACT_PATH(X, OWN, "/own")                                                              \
    RMAP_COMPACT_PATH(X, PATH, "/path")                                                            \
    X(triangle, TRIANGLE, "/triangle/primitive", U32, "triangle met, for legs that end on a mesh") \
    X(patch_skip, PATCH, "/patch/skip", U32, "numbers predicted well since the last patch of the lane") \
    X(patch_value, PATCH, "/patch/value", U64, "residual to the prediction")                       \
    X(pool16, POOL16, "/pool16/value", U16, "lanes of 16-bit numbers that are stored in full")     \
    X(pool32, POOL32, "/pool32/value", U32, "lanes of 32-bit numbers that are stored in full")     \
    X(pool64, POOL64, "/pool64/value", U64, "header of the portion, then 64-bit lanes stored in full")
/* clang-format on */

enum rmap_compact_table {
#define RMAP_ENUM(name, path) RMAP_COMPACT_##name,
    RMAP_COMPACT_TABLES(RMAP_ENUM)
#undef RMAP_ENUM
        RMAP_COMPACT_TABLE_COUNT
};

enum rmap_compact_stream {
#define RMAP_ENUM(name, table, path, element, text) RMAP_STREAM_##name,
    RMAP_COMPACT_STREAMS(RMAP_ENUM)
#undef RMAP_ENUM
#define RMAP_ENUM(field, path, type, element, width, unit, text) RMAP_STREAM_curve_##field,
        RMAP_CURVE_COLUMNS(RMAP_ENUM)
#undef RMAP_ENUM
            RMAP_COMPACT_STREAM_COUNT
};

/* Paths of a piece, and their rows in all three tables together: no more are entered. */
#define RMAP_PATH_MAX     65536
#define RMAP_PATH_ROW_MAX ((size_t)4 << 20)

/* placed, here and below: places of the portion's registrations stand by themselves, as its header
 * says; false is on the safe side. */

/* Columns for which rays are traced again, which takes longest by far. */
rmap_column_set rmap_compact_traced(bool placed);

/* Columns that must be decoded so that these can be, themselves among them. */
rmap_column_set rmap_compact_needs(rmap_column_set columns, bool placed);

/* Streams (bit s: stream s of the layout) that decoding these columns needs, without those of the
 * whole tables, by the portion's header (NULL: not known; then all that may be needed). */
uint64_t rmap_compact_streams(rmap_column_set columns, const struct rmap_compact_summary *header);

/* Whether more than heads of paths tells of them. */
bool rmap_compact_needs_rows(rmap_column_set columns);

/* The stream of rmap_compact_summarise_header, and those of rmap_compact_summarise; where rays with
 * paths of their own are all, the latter are fewer. */
uint64_t rmap_compact_header_streams(void);
uint64_t rmap_compact_summary_streams(bool own_alone);

/* Those of rmap_compact_decode_own, for some of RMAP_COLUMNS_DISCRETE; references to paths with
 * /ray/id, which they tell. */
uint64_t rmap_compact_own_streams(rmap_column_set columns,
                                  const struct rmap_compact_summary *header);

/* Streams of the classes that segments of own paths have, where the header says so. */
uint64_t rmap_compact_class_streams(void);

#endif
