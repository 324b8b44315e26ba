/* SPDX-License-Identifier: MIT
 *
 * The columns of a ray map, once. These tables drive the in-memory portion, the writer, the
 * reader, the digest (columns in this order), the docs and the format test.
 *
 * X(field, dataset, C type, element, width, unit, description)
 *   element: U8 U16 I16 U32 I32 U64 F32 F64; width: numbers per row;
 *   unit: ONE (dimensionless), LENGTH (the scene's unit), NM (wavelength).
 * The colour of a segment is beside them (struct rmap_portion.colour): its width is the
 * number of channels of the portion's colour space. /curve comes behind them: only maps of scenes
 * with gradient media, or of timed runs, store it; and last the columns of timed runs.
 */
#ifndef RMAP_COLUMNS_H
#define RMAP_COLUMNS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* clang-format off */
#define RMAP_RAY_COLUMNS(X)                                                                        \
    X(id, "/ray/id", uint64_t, U64, 1, ONE, "ray id, from 0")                                      \
    X(source, "/ray/source", int32_t, I32, 1, ONE, "index of the source in /name/source")          \
    X(stop, "/ray/stop", uint8_t, U8, 1, ONE, "why the ray ended: 0 absorbed, 1 left the scene, 2 limit, 3 error") \
    X(weight, "/ray/weight", double, F64, 1, ONE, "relative weight at the end, 1 at emission; flux = weight x source flux / source's rays in the map") \
    X(segment_count, "/ray/segment_count", uint32_t, U32, 1, ONE, "rows of this ray in /segment; row offsets are the running sum") \
    X(registration_count, "/ray/registration_count", uint32_t, U32, 1, ONE, "rows of this ray in /registration; row offsets are the running sum") \
    X(wavelength, "/ray/wavelength", double, F64, 1, NM, "vacuum wavelength at the end; NaN where more than one channel is left") \
    X(path_length, "/ray/path_length", double, F64, 1, LENGTH, "geometric length, without a leg that leaves the scene") \
    X(optical_path, "/ray/optical_path", double, F64, 1, LENGTH, "optical path length, without a leg that leaves the scene") \
    X(start, "/ray/start", float, F32, 3, LENGTH, "point of emission")                             \
    X(start_object, "/ray/start_object", int32_t, I32, 1, ONE, "object emitted from; -1: none")    \
    X(start_primitive, "/ray/start_primitive", int32_t, I32, 1, ONE, "primitive emitted from; -1: none") \
    X(start_normal, "/ray/start_normal", int16_t, I16, 3, ONE, "normal at the point of emission x 32767; 0 without a surface") \
    X(end_direction, "/ray/end_direction", float, F32, 3, ONE, "unit direction in which it left the scene; 0 otherwise")

#define RMAP_SEGMENT_COLUMNS(X)                                                                    \
    X(object, "/segment/object", int32_t, I32, 1, ONE, "object met at the end of the leg; -1: none (left, or inside a medium)") \
    X(primitive, "/segment/primitive", int32_t, I32, 1, ONE, "triangle of the object's mesh; 0 for analytic surfaces; -1 without an object") \
    X(event, "/segment/event", uint32_t, U32, 1, ONE, "bits of what happened at the end of the leg; see the attribute `bits`") \
    X(medium, "/segment/medium", int16_t, I16, 1, ONE, "medium travelled, index in /name/medium")  \
    X(position, "/segment/position", float, F32, 3, LENGTH, "end of the leg")                      \
    X(normal, "/segment/normal", int16_t, I16, 3, ONE, "surface normal at the end x 32767, unflipped; 0 without a surface")

#define RMAP_REGISTRATION_COLUMNS(X)                                                               \
    X(segment, "/registration/segment", uint32_t, U32, 1, ONE, "leg on which it happened, from 0 within the ray") \
    X(detector, "/registration/detector", int32_t, I32, 1, ONE, "index in /name/detector")         \
    X(cell, "/registration/cell", uint16_t, U16, 2, ONE, "cell (i, j) from least x, least y")      \
    X(relative, "/registration/relative", uint16_t, U16, 2, ONE, "relative coordinates x 65535")   \
    X(registered, "/registration/registered", uint8_t, U8, 1, ONE, "1 registered, 0 only crossed (side or angle limits)") \
    X(direction, "/registration/direction", float, F32, 3, ONE, "unit direction of the light")     \
    X(optical_path, "/registration/optical_path", double, F64, 1, LENGTH, "optical path length from emission to here")

#define RMAP_CURVE_COLUMNS(X)                                                                      \
    X(ray, "/curve/ray", uint64_t, U64, 1, ONE, "ray id; a ray's rows lie together, the rays in the order of /ray/id") \
    X(segment, "/curve/segment", uint32_t, U32, 1, ONE, "curved leg that the point lies on, from 0 within the ray") \
    X(position, "/curve/position", float, F32, 3, LENGTH, "point of the leg between its ends, along the light")

/* Of /ray and /registration, in timed runs. */
#define RMAP_RAY_TIME_COLUMNS(X)                                                                   \
    X(group_path, "/ray/group_path", double, F64, 1, LENGTH, "group path length, without a leg that leaves the scene") \
    X(delay, "/ray/delay", double, F64, 1, NS, "delays at emission and on the way; time of arrival = delay + group path / c")

#define RMAP_REGISTRATION_TIME_COLUMNS(X)                                                          \
    X(group_path, "/registration/group_path", double, F64, 1, LENGTH, "group path length from emission to here") \
    X(delay, "/registration/delay", double, F64, 1, NS, "delays up to here; time of arrival = delay + group path / c")
/* clang-format on */

enum rmap_table {
    RMAP_TABLE_RAY,
    RMAP_TABLE_SEGMENT,
    RMAP_TABLE_REGISTRATION,
    RMAP_TABLE_CURVE,
    RMAP_TABLE_COUNT
};

/* The first tables, which say what a ray met: criteria are about these. */
#define RMAP_TABLE_HISTORY_COUNT ((int)RMAP_TABLE_CURVE)

enum rmap_element { RMAP_U8, RMAP_U16, RMAP_I16, RMAP_U32, RMAP_I32, RMAP_U64, RMAP_F32, RMAP_F64 };

enum rmap_unit { RMAP_UNIT_ONE, RMAP_UNIT_LENGTH, RMAP_UNIT_NM, RMAP_UNIT_NS };

/* Column ids: RMAP_RAY_id ..., RMAP_SEGMENT_object ..., RMAP_REGISTRATION_segment ...,
 * RMAP_CURVE_ray ... */
enum rmap_column {
#define RMAP_ENUM(field, path, type, element, width, unit, text) RMAP_RAY_##field,
    RMAP_RAY_COLUMNS(RMAP_ENUM)
#undef RMAP_ENUM
#define RMAP_ENUM(field, path, type, element, width, unit, text) RMAP_SEGMENT_##field,
        RMAP_SEGMENT_COLUMNS(RMAP_ENUM)
#undef RMAP_ENUM
#define RMAP_ENUM(field, path, type, element, width, unit, text) RMAP_REGISTRATION_##field,
            RMAP_REGISTRATION_COLUMNS(RMAP_ENUM)
#undef RMAP_ENUM
                RMAP_SEGMENT_colour, /* width known at run time: channels */
#define RMAP_ENUM(field, path, type, element, width, unit, text) RMAP_CURVE_##field,
    RMAP_CURVE_COLUMNS(RMAP_ENUM)
#undef RMAP_ENUM
#define RMAP_ENUM(field, path, type, element, width, unit, text) RMAP_RAY_##field,
        RMAP_RAY_TIME_COLUMNS(RMAP_ENUM)
#undef RMAP_ENUM
#define RMAP_ENUM(field, path, type, element, width, unit, text) RMAP_REGISTRATION_##field,
            RMAP_REGISTRATION_TIME_COLUMNS(RMAP_ENUM)
#undef RMAP_ENUM
                RMAP_COLUMN_COUNT
};

/* Set of columns: bit c stands for column c. */
typedef uint64_t rmap_column_set;
#define RMAP_COLUMN_BIT(column) ((rmap_column_set)1 << (column))
#define RMAP_COLUMNS_ALL        (RMAP_COLUMN_BIT(RMAP_COLUMN_COUNT) - 1)
#define RMAP_COLUMNS_CURVE                                                                         \
    (RMAP_COLUMN_BIT(RMAP_CURVE_ray) | RMAP_COLUMN_BIT(RMAP_CURVE_segment) |                       \
     RMAP_COLUMN_BIT(RMAP_CURVE_position))
#define RMAP_COLUMNS_TIME                                                                          \
    (RMAP_COLUMN_BIT(RMAP_RAY_group_path) | RMAP_COLUMN_BIT(RMAP_RAY_delay) |                      \
     RMAP_COLUMN_BIT(RMAP_REGISTRATION_group_path) | RMAP_COLUMN_BIT(RMAP_REGISTRATION_delay))

/* Those that the rays of a run have. */
static inline rmap_column_set rmap_columns_of_run(bool timed)
{
    return timed ? RMAP_COLUMNS_ALL : RMAP_COLUMNS_ALL & ~RMAP_COLUMNS_TIME;
}

/* No column: what a compact piece knows about the angles of registrations, where places stand by
 * themselves (struct rmap_portion.angle). */
#define RMAP_COLUMNS_ANGLES RMAP_COLUMN_BIT(RMAP_COLUMN_COUNT)

/* What readers of such a run may ask for. */
static inline rmap_column_set rmap_columns_known(bool timed)
{
    return rmap_columns_of_run(timed) | RMAP_COLUMNS_ANGLES;
}

/* What of a ray is no number measured: equal for all rays of the same path. */
#define RMAP_COLUMNS_DISCRETE                                                                      \
    (RMAP_COLUMN_BIT(RMAP_RAY_source) | RMAP_COLUMN_BIT(RMAP_RAY_stop) |                           \
     RMAP_COLUMN_BIT(RMAP_RAY_segment_count) | RMAP_COLUMN_BIT(RMAP_RAY_registration_count) |      \
     RMAP_COLUMN_BIT(RMAP_SEGMENT_object) | RMAP_COLUMN_BIT(RMAP_SEGMENT_event) |                  \
     RMAP_COLUMN_BIT(RMAP_SEGMENT_medium) | RMAP_COLUMN_BIT(RMAP_REGISTRATION_segment) |           \
     RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector) | RMAP_COLUMN_BIT(RMAP_REGISTRATION_registered))

/* What is told of rays that arrive at detectors without the others (src/compact/arrivals.h). */
#define RMAP_COLUMNS_ARRIVAL                                                                       \
    (RMAP_COLUMNS_DISCRETE | RMAP_COLUMN_BIT(RMAP_RAY_weight) |                                    \
     RMAP_COLUMN_BIT(RMAP_REGISTRATION_relative) | RMAP_COLUMN_BIT(RMAP_REGISTRATION_cell))

struct rmap_column_info {
    enum rmap_table table;
    const char *field;
    const char *path; /* dataset; colour: chosen by colour space, "/segment/colour_rgb" or
                         "/segment/colour_spectral" */
    enum rmap_element element;
    int width; /* numbers per row; 0 for colour */
    enum rmap_unit unit;
    const char *description;
};

/* Descriptor of column c in [0, RMAP_COLUMN_COUNT). */
const struct rmap_column_info *rmap_column_info(enum rmap_column column);

size_t rmap_element_nbytes(enum rmap_element element);

#endif
