/* SPDX-License-Identifier: MIT
 *
 * What a piece stores for the columns of its portions.
 */
#include "compact/layout.h"

#include "compact/compact.h"

/* clang-format off */
#define RAY(field, path, type, element, width, unit, text)                                         \
    {RMAP_TABLE_RAY, path, RMAP_##element, width, RMAP_UNIT_##unit, text},
#define SEGMENT(field, path, type, element, width, unit, text)                                     \
    {RMAP_TABLE_SEGMENT, path, RMAP_##element, width, RMAP_UNIT_##unit, text},
#define REGISTRATION(field, path, type, element, width, unit, text)                                \
    {RMAP_TABLE_REGISTRATION, path, RMAP_##element, width, RMAP_UNIT_##unit, text},
#define CURVE(field, path, type, element, width, unit, text)                                       \
    {RMAP_TABLE_CURVE, path, RMAP_##element, width, RMAP_UNIT_##unit, text},
#define RAY_TIME(field, path, type, element, width, unit, text)                                    \
    {RMAP_PLAIN_RAY_TIME, path, RMAP_##element, width, RMAP_UNIT_##unit, text},
#define REGISTRATION_TIME(field, path, type, element, width, unit, text)                           \
    {RMAP_PLAIN_REGISTRATION_TIME, path, RMAP_##element, width, RMAP_UNIT_##unit, text},
#define COLOUR(path)                                                                               \
    {RMAP_TABLE_SEGMENT, path, RMAP_U16, 0, RMAP_UNIT_ONE,                                         \
     "share of the ray's flux per channel on the leg's arrival x 65535; a row sums to 65535"},
#define PLAIN(colour_path)                                                                         \
    {RMAP_RAY_COLUMNS(RAY) RMAP_SEGMENT_COLUMNS(SEGMENT)                                           \
     RMAP_REGISTRATION_COLUMNS(REGISTRATION) COLOUR(colour_path) RMAP_CURVE_COLUMNS(CURVE)          \
     RMAP_RAY_TIME_COLUMNS(RAY_TIME) RMAP_REGISTRATION_TIME_COLUMNS(REGISTRATION_TIME)}
/* clang-format on */

static const struct rmap_stream_info plain_spectral[] = PLAIN("/segment/colour_spectral");
static const struct rmap_stream_info plain_rgb[] = PLAIN("/segment/colour_rgb");

_Static_assert(sizeof plain_rgb / sizeof *plain_rgb == RMAP_COLUMN_COUNT,
               "plain streams are the columns");
_Static_assert(RMAP_COLUMN_COUNT <= RMAP_STREAM_MAX, "streams of the plain encoding");
_Static_assert((int)RMAP_PLAIN_TABLE_COUNT <= (int)RMAP_STORED_TABLE_STRAIGHT,
               "tables of that encoding");

static const char *const plain_table[] = {"/ray",   "/segment", "/registration",
                                          "/curve", "/ray",     "/registration"};

#define LAYOUT(streams)                                                                            \
    {                                                                                              \
        .encoding = RMAP_ENCODING_PLAIN, .n_table = RMAP_PLAIN_TABLE_COUNT,                        \
        .table_path = plain_table, .n_stream = RMAP_COLUMN_COUNT, .stream = streams,               \
        .curve_table = RMAP_TABLE_CURVE, .curve_stream = RMAP_CURVE_ray,                           \
        .time_stream = RMAP_RAY_group_path                                                         \
    }
static const struct rmap_layout plain[] = {
    [RMAP_COLOUR_SPECTRAL] = LAYOUT(plain_spectral),
    [RMAP_COLOUR_RGB] = LAYOUT(plain_rgb),
};
#undef LAYOUT

const struct rmap_layout *rmap_layout_of(enum rmap_encoding encoding, enum rmap_colour_mode mode)
{
    switch (encoding) {
    case RMAP_ENCODING_PLAIN:
        return &plain[mode == RMAP_COLOUR_RGB];
    case RMAP_ENCODING_COMPACT:
        return &rmap_compact_layout;
    default:
        return NULL;
    }
}

int rmap_layout_n_table(const struct rmap_layout *layout, const struct rmap_scene *scene)
{
    return layout->curve_table + (rmap_scene_keeps_curves(scene) ? 1 : 0);
}

int rmap_layout_n_stream(const struct rmap_layout *layout, const struct rmap_scene *scene)
{
    return scene->timed                     ? layout->n_stream
           : rmap_scene_keeps_curves(scene) ? layout->time_stream
                                            : layout->curve_stream;
}

const char *rmap_encoding_name(enum rmap_encoding encoding)
{
    return encoding == RMAP_ENCODING_COMPACT ? "compact" : "plain";
}

size_t rmap_stream_width(const struct rmap_stream_info *stream, int n_channel)
{
    return stream->width > 0 ? (size_t)stream->width : (size_t)n_channel;
}

size_t rmap_stream_row_nbytes(const struct rmap_stream_info *stream, int n_channel)
{
    return rmap_stream_width(stream, n_channel) * rmap_element_nbytes(stream->element);
}

void rmap_rows_of_portion(const struct rmap_portion *portion, enum rmap_colour_mode mode,
                          struct rmap_rows *rows)
{
    *rows = (struct rmap_rows){.layout = rmap_layout_of(RMAP_ENCODING_PLAIN, mode),
                               .n_channel = portion->n_channel};
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        rows->n_row[t] = portion->n_row[t];
    rows->n_row[RMAP_PLAIN_RAY_TIME] = portion->timed ? portion->n_row[RMAP_TABLE_RAY] : 0;
    rows->n_row[RMAP_PLAIN_REGISTRATION_TIME] =
        portion->timed ? portion->n_row[RMAP_TABLE_REGISTRATION] : 0;
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        rows->data[c] = rmap_portion_column(portion, (enum rmap_column)c);
}
