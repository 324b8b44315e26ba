/* SPDX-License-Identifier: MIT
 *
 * A cursor, for the files that make it up.
 */
#ifndef RMAP_MAP_CURSOR_INTERNAL_H
#define RMAP_MAP_CURSOR_INTERNAL_H

#include "compact/arrivals.h"
#include "compact/compact.h"
#include "compact/decode_paths.h"
#include "compact/ray_selection.h"
#include "compact/streams.h"
#include "io/map/chunk_reader.h"
#include "io/map/map_cursor.h"
#include "io/map/map_internal.h"

/* Rays are selected as they stand, or traced again: neither takes the place of the other. */
enum { RMAP_CURSOR_SELECTIONS = 2 };

/* What a colour space takes; made when first needed. */
struct rmap_cursor_space {
    struct rmap_portion *portion, *selected[RMAP_CURSOR_SELECTIONS];
    struct rmap_compact_decoder *decoder;
    struct rmap_compact_selection *selection;
};

/* Rays of the portion in hand that were selected. */
struct rmap_cursor_selected {
    struct rmap_portion shown; /* as the cursor's; of the space in hand */
    rmap_column_set columns;   /* 0: none yet */
    uint32_t *ray;             /* [cap] their rows in the portion */
    size_t cap;
};

/* A stream's rows of the portion in hand, for the decoder. */
struct rmap_row_buffer {
    void *data;
    size_t cap; /* bytes */
};

struct rmap_cursor {
    const struct rmap_map *map;
    rmap_column_set columns;
    struct rmap_chunk_reader *reader;
    struct rmap_cursor_space *space; /* [n_space] */
    size_t in_hand;                  /* portion of the map */
    rmap_column_set present;         /* columns of it that have been read */
    rmap_column_set kept;            /* and those that the map's store has */
    uint64_t streams;                /* of a compact one, in `buffer` */
    bool add_up;                     /* its paths and counts were found to fit together */
    bool is_narrow;                  /* the rays that arrive are taken for all of it: */
    struct rmap_arrivals arrivals;
    bool knows_header; /* of a compact one: */
    struct rmap_compact_summary header;
    const uint8_t *passed_over;   /* rays of it; NULL: none */
    struct rmap_portion *portion; /* of the space in hand; borrowed from there */
    struct rmap_portion shown;    /* that, without columns that only decoding needed */
    struct rmap_cursor_selected selected[RMAP_CURSOR_SELECTIONS];
    struct rmap_row_buffer beside; /* rows that are compared with decoded ones */
    struct rmap_row_buffer buffer[RMAP_STREAM_MAX];
    const struct rmap_path_table *paths; /* of a compact piece; NULL: none in hand */
    bool whole_paths;                    /* their heads are not enough */
    size_t paths_piece;                  /* whose they are */
    struct rmap_portion *own;            /* rays with paths of their own, of the portion in hand, */
    rmap_column_set own_columns;         /* with these columns */
    struct rmap_step_buffer steps;       /* classes of their segments */
    struct rmap_path_sum *own_sum;       /* their bounds */
    size_t own_sum_cap;
};

/* map_cursor.c */

/* Of these columns of a compact portion, those that are read from beside its piece: where others
 * have its rays traced again, they come with them. */
enum rmap_status rmap_cursor_choose_beside(struct rmap_cursor *self,
                                           const struct rmap_portion_info *info,
                                           rmap_column_set columns, rmap_column_set *beside_ret,
                                           struct rmap_error *err) RMAP_MUST_USE;
void rmap_cursor_show_columns(const struct rmap_portion *rows, rmap_column_set columns,
                              struct rmap_portion *shown);

/* map_cursor_compact.c */

/* What any use of the portion's rows takes. */
struct rmap_cursor_rows {
    const struct rmap_compact_model *model;
    struct rmap_rows rows;
    size_t n_row[RMAP_TABLE_COUNT]; /* of the columns */
};

/* Gives the paths in hand back, unless they are those of that piece. */
void rmap_cursor_leave_paths(struct rmap_cursor *self, size_t piece);
enum rmap_status rmap_cursor_enter_rows(struct rmap_cursor *self,
                                        const struct rmap_portion_info *info, uint64_t streams,
                                        struct rmap_cursor_rows *in_hand,
                                        struct rmap_error *err) RMAP_MUST_USE;
void rmap_cursor_say_where(const struct rmap_cursor *self, const struct rmap_portion_info *info,
                           struct rmap_error *err);
/* Reads the header of the portion in hand, if it has one. */
enum rmap_status rmap_cursor_know_header(struct rmap_cursor *self,
                                         struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_cursor_make_decoder(struct rmap_cursor *self,
                                          const struct rmap_portion_info *info,
                                          struct rmap_error *err) RMAP_MUST_USE;
/* Decodes columns of a portion of a compact piece into the cursor's portion, where those that are
 * present stay. */
enum rmap_status rmap_cursor_read_compact(struct rmap_cursor *self,
                                          const struct rmap_portion_info *info,
                                          rmap_column_set columns,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* map_cursor_check.c: what is read is not believed. */

#define RMAP_CELL_COLUMNS                                                                          \
    (RMAP_COLUMN_BIT(RMAP_REGISTRATION_cell) | RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector))
#define RMAP_CURVE_CHECK_COLUMNS                                                                   \
    (RMAP_COLUMN_BIT(RMAP_CURVE_ray) | RMAP_COLUMN_BIT(RMAP_CURVE_segment) |                       \
     RMAP_COLUMN_BIT(RMAP_RAY_id) | RMAP_COLUMN_BIT(RMAP_RAY_segment_count))

/* Values of columns of rows of that portion must name something of the scene. */
enum rmap_status rmap_cursor_check_limits(const struct rmap_cursor *self,
                                          const struct rmap_portion *rows, rmap_column_set columns,
                                          const struct rmap_portion_info *info,
                                          struct rmap_error *err) RMAP_MUST_USE;
/* What the columns `fresh`, just read, say of the rows. */
enum rmap_status rmap_cursor_check_columns(const struct rmap_cursor *self,
                                           const struct rmap_portion_info *info,
                                           rmap_column_set fresh,
                                           struct rmap_error *err) RMAP_MUST_USE;
/* Cells index images. */
enum rmap_status rmap_cursor_check_cells(const struct rmap_cursor *self,
                                         const struct rmap_portion *rows,
                                         struct rmap_error *err) RMAP_MUST_USE;
/* Every point lies on a segment of a ray of the portion, in their order. */
enum rmap_status rmap_cursor_check_curve(const struct rmap_cursor *self,
                                         struct rmap_error *err) RMAP_MUST_USE;

#endif
