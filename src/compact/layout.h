/* SPDX-License-Identifier: MIT
 *
 * What a piece stores for the columns of its portions. A stream is one flat dataset, a stored
 * table the streams that have the same number of rows; a layout lists both for an encoding.
 * In the plain encoding the streams are the columns, in their order.
 */
#ifndef RMAP_LAYOUT_H
#define RMAP_LAYOUT_H

#include "portion/portion.h"
#include "scene/scene.h"

enum rmap_encoding { RMAP_ENCODING_PLAIN, RMAP_ENCODING_COMPACT, RMAP_ENCODING_COUNT };

#define RMAP_STORED_TABLE_MAX 13
#define RMAP_STREAM_MAX       60

/* Without that of /curve: maps of scenes without gradient media state the rows of so many. */
#define RMAP_STORED_TABLE_STRAIGHT 12

/* Stored tables of the plain encoding: the logical ones, and those of what timed runs have beside
 * them, with no rows in others. */
enum {
    RMAP_PLAIN_RAY_TIME = RMAP_TABLE_COUNT,
    RMAP_PLAIN_REGISTRATION_TIME,
    RMAP_PLAIN_TABLE_COUNT
};

struct rmap_stream_info {
    int table;        /* of the layout's table_path */
    const char *path; /* dataset */
    enum rmap_element element;
    int width; /* numbers per row; 0: as many as the colour space has channels */
    enum rmap_unit unit;
    const char *description;
};

struct rmap_layout {
    enum rmap_encoding encoding;
    int n_table;
    const char *const *table_path; /* [n_table], groups: "/ray" ... */
    int n_stream;
    const struct rmap_stream_info *stream; /* [n_stream] */
    uint32_t whole_tables;  /* bit t: rows of table t belong to the piece as a whole and stand in no
                               portion's range; a reader loads the table entirely */
    uint32_t run_tables;    /* bit t: chunks of table t are deflated by runs of a byte alone where
                               that takes less */
    uint64_t quick_streams; /* bit s: stream s is read by so many questions that chunks of it which
                               deflate little are stored as they are */
    int curve_table, curve_stream; /* /curve and its streams: only files of scenes with gradient
                                      media, or of timed ones, have them, see below */
    int time_stream; /* the first of those that only files of timed scenes have, the last ones */
};

/* Groups and streams that files of a scene have; they are the first ones of the layout. In memory
 * every layout has all of them, with no rows in those that a file lacks. */
int rmap_layout_n_table(const struct rmap_layout *layout, const struct rmap_scene *scene);
int rmap_layout_n_stream(const struct rmap_layout *layout, const struct rmap_scene *scene);

/* Constant. NULL for an encoding that this program does not know. The mode chooses the name of
 * the colours' dataset alone: streams have the same numbers and widths in both. */
const struct rmap_layout *rmap_layout_of(enum rmap_encoding encoding, enum rmap_colour_mode mode);

/* "plain", "compact". */
const char *rmap_encoding_name(enum rmap_encoding encoding);

/* Numbers and bytes in a row of a stream. */
size_t rmap_stream_width(const struct rmap_stream_info *stream, int n_channel);
size_t rmap_stream_row_nbytes(const struct rmap_stream_info *stream, int n_channel);

/* Rows of a block in a layout: what a shard appends and what a cursor reads. A reader's rows may
 * lack streams (NULL) that were not asked for. Whoever hands them out says who owns the data. */
struct rmap_rows {
    const struct rmap_layout *layout;
    int n_channel;
    bool add_up; /* of compact ones it is known that paths and counts fit together */
    size_t n_row[RMAP_STORED_TABLE_MAX];
    void *data[RMAP_STREAM_MAX]; /* [n_row of its table][width] */
};

/* The rows of a portion in the plain encoding: its own columns, borrowed. */
void rmap_rows_of_portion(const struct rmap_portion *portion, enum rmap_colour_mode mode,
                          struct rmap_rows *rows);

#endif
