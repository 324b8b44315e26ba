/* SPDX-License-Identifier: MIT
 *
 * A ray's path as 32-bit words: head (source, stop, start object + 1, segments, registrations),
 * then object + 1 of each segment, 0 and the one expected swapped, then its event xor the one
 * expected, then segment, detector and registered of each registration. Equal words are equal
 * paths.
 */
#ifndef RMAP_COMPACT_PATHS_H
#define RMAP_COMPACT_PATHS_H

#include "compact/model.h"
#include "compact/step_classes.h"
#include "compact/step_codes.h"
#include "compact/streams.h"

enum {
    RMAP_WORD_SOURCE,
    RMAP_WORD_STOP,
    RMAP_WORD_START_OBJECT,
    RMAP_WORD_SEGMENTS,
    RMAP_WORD_REGISTRATIONS,
    RMAP_WORD_HEAD
};

/* Rows of paths as they go into a piece. */
struct rmap_path_rows {
    int32_t *source, *detector;
    uint8_t *stop, *registered;
    uint32_t *start_object, *segment_count, *registration_count, *object, *event, *segment;
    size_t n, n_segment, n_registration; /* rows in use */
    size_t cap, cap_segment, cap_registration;
};
enum rmap_status rmap_path_rows_reserve(struct rmap_path_rows *rows, size_t n, size_t n_segment,
                                        size_t n_registration,
                                        struct rmap_error *err) RMAP_MUST_USE;
void rmap_path_rows_add(struct rmap_path_rows *rows, const uint32_t *word); /* there is room */
void rmap_path_rows_fini(struct rmap_path_rows *rows);

static inline size_t rmap_path_n_word(const uint32_t *word)
{
    return RMAP_WORD_HEAD + 2 * (size_t)word[RMAP_WORD_SEGMENTS] +
           3 * (size_t)word[RMAP_WORD_REGISTRATIONS];
}

/* A path as it is stored. */
struct rmap_folded_path {
    int32_t source;
    uint8_t stop;
    size_t n; /* segments */
    const uint32_t *object, *event;
};

/* Where a path's segments go; any column may be NULL. */
struct rmap_path_columns {
    int32_t *object;
    uint32_t *event;
    int16_t *medium; /* as rmap_path_media says */
};
void rmap_path_unfold(const struct rmap_compact_model *model, const struct rmap_folded_path *path,
                      const struct rmap_path_columns *out);

/* The event of the last segment: another one is expected there. */
static inline void rmap_path_end(const struct rmap_folded_path *path,
                                 const struct rmap_path_columns *out)
{
    if (out->event && path->n > 0)
        out->event[path->n - 1] = path->event[path->n - 1] ^ rmap_event_at_end(path->stop);
}

/* Added up ray by ray, both at once. */
struct rmap_path_count {
    uint64_t n_segment, n_registration;
};

struct rmap_path_table {
    size_t n, n_segment, n_registration;
    bool is_whole; /* else what heads tell is all: neither rows, n_listed nor classes */
    struct rmap_path_count *count; /* [n + 1]: of path i - 1; the first is 0 */
    uint32_t *n_listed;            /* the same: segments whose triangle is listed */
    int32_t *start_object;         /* [n + 1] */
    int32_t *object;               /* [n_segment] */
    uint32_t *event;
    int16_t *medium;   /* as rmap_path_media says */
    uint32_t *segment; /* [n_registration] */
    int32_t *detector;
    uint8_t *registered;
    struct rmap_step_classes classes; /* of their segments */
    uint8_t *listed;                  /* [classes.n + 1] 1: triangles of such segments are listed */
    struct rmap_portion rays; /* the paths as rays: heads of its own, the other columns are these */
    uint32_t *first_segment, *first_registration; /* [n + 1] rows of them */
};

/* The paths of a piece being read, from all rows of its whole tables (other streams may be NULL),
 * or from those of their heads alone; copied. Immutable. RMAP_FORMAT when the rows do not fit
 * together. */
enum rmap_status rmap_path_table_create(const struct rmap_compact_model *model,
                                        const struct rmap_rows *rows,
                                        struct rmap_path_table **table_ret,
                                        struct rmap_error *err) RMAP_MUST_USE;
void rmap_path_table_destroy(struct rmap_path_table *table);
size_t rmap_path_table_nbytes(const struct rmap_path_table *table); /* of memory */

/* The paths as rays of a portion, with columns RMAP_COLUMNS_DISCRETE, or those of them that are of
 * rays; the others are NULL. Borrowed from the table. Values are as untrusted as the rows. */
const struct rmap_portion *rmap_path_table_rays(const struct rmap_path_table *table);

/* Of its segments' steps. */
const struct rmap_step_classes *rmap_path_table_classes(const struct rmap_path_table *table);

/* [its rays] the first of each one's rows. */
const uint32_t *rmap_path_table_first_segments(const struct rmap_path_table *table);
const uint32_t *rmap_path_table_first_registrations(const struct rmap_path_table *table);

/* What the portion's header says of it: all but path and n_own. RMAP_FORMAT where there is none. */
enum rmap_status rmap_compact_summarise_header(const struct rmap_rows *rows,
                                               struct rmap_compact_summary *summary,
                                               struct rmap_error *err) RMAP_MUST_USE;

/* rows, n_row: as for decoding, by which RMAP_FORMAT is found here, too. */
enum rmap_status
rmap_compact_summarise(const struct rmap_compact_model *model, const struct rmap_path_table *table,
                       const struct rmap_rows *rows, const size_t n_row[RMAP_TABLE_COUNT],
                       struct rmap_compact_summary *summary, struct rmap_error *err) RMAP_MUST_USE;

/* The rays with paths of their own, side by side, of rows that were summed up: segment_count and
 * those of RMAP_COLUMNS_DISCRETE that `columns` names, media as the paths say; and room for id and
 * weight. rows: of rmap_compact_own_streams. steps: room for classes of segments. out: emptied
 * first. RMAP_FORMAT when counts do not sum up to the rows. */
enum rmap_status
rmap_compact_decode_own(const struct rmap_compact_model *model, const struct rmap_path_table *table,
                        const struct rmap_rows *rows, const struct rmap_compact_summary *header,
                        rmap_column_set columns, struct rmap_step_buffer *steps,
                        struct rmap_portion *out, struct rmap_error *err) RMAP_MUST_USE;

#endif
