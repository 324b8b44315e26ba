/* SPDX-License-Identifier: MIT
 *
 * The history index of a piece: everything of its rays that is no floating number (source, stop,
 * object, event and medium of each segment, detector of each registration), in a form that a
 * question is answered from without a column being inflated. Derived data: what it says, the
 * columns say. No files: bytes come from memory or from a function that reads them.
 *
 * Each portion is in one of two forms. PATHS: rays that did the same share a path of the piece's
 * dictionary, and the portion has a path per ray. ROWS: each segment has its class (object, event,
 * medium) in about a byte. Portions that fit neither (wider numbers than any example's) are left
 * out: they are not found, and their columns are to be read.
 */
#ifndef RMAP_HISTORY_INDEX_H
#define RMAP_HISTORY_INDEX_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/byte_set.h"
#include "base/status.h"
#include "compact/step_classes.h"
#include "portion/portion.h"

/* Columns that an index is built of; it gives the discrete ones back. */
#define RMAP_HISTORY_COLUMNS                                                                       \
    (RMAP_COLUMNS_DISCRETE | RMAP_COLUMN_BIT(RMAP_RAY_weight) |                                    \
     RMAP_COLUMN_BIT(RMAP_REGISTRATION_relative))

/* Of one piece. Immutable, thread-safe. */
struct rmap_history_index;
void rmap_history_destroy(struct rmap_history_index *index);

/* Memory that it holds, without a body in memory. */
size_t rmap_history_nbytes(const struct rmap_history_index *index);

/* What can happen on a detector: that does in the piece, as the classes of its steps do. */
struct rmap_history_hit {
    int32_t detector;
    int32_t registered; /* 1, or 0: crossed only */
};
size_t rmap_history_n_class(const struct rmap_history_index *index);
const struct rmap_step_class *rmap_history_classes(const struct rmap_history_index *index);
size_t rmap_history_n_hit(const struct rmap_history_index *index);
const struct rmap_history_hit *rmap_history_hits(const struct rmap_history_index *index);

/* The dictionary as a portion: its rays are the distinct paths, its columns RMAP_COLUMNS_DISCRETE,
 * the others are NULL. 0 rays: no portion is in the form PATHS. */
const struct rmap_portion *rmap_history_paths(const struct rmap_history_index *index);

size_t rmap_history_n_portion(const struct rmap_history_index *index);

/* The portion of the index that holds the rays of this one of the map: first ray, rows and digest
 * decide. SIZE_MAX: none does, for whatever reason; the columns are to be read. */
size_t rmap_history_find(const struct rmap_history_index *index, uint64_t first_ray,
                         const uint64_t n_row[RMAP_TABLE_HISTORY_COUNT], struct rmap_digest digest);

enum rmap_history_form { RMAP_HISTORY_PATHS, RMAP_HISTORY_ROWS };

/* One portion opened for reading. Zero it before the first open; one per thread; each open replaces
 * what was there and reuses its memory. The index must outlive what is open. */
struct rmap_history_view {
    const struct rmap_history_index *index;
    enum rmap_history_form form;
    uint64_t first_ray;
    size_t n_row[RMAP_TABLE_HISTORY_COUNT];
    bool unit_weight; /* every weight is exactly 1: sums of weights are numbers of rays. Otherwise
                         the column is to be read */
    const uint16_t *relative; /* [n_registration][2] in the order of /registration, or NULL: the
                                 column is to be read */
    uint64_t nbytes;          /* of the index that this view was read from */

    /* PATHS. Rays of path k, path_rays[k] of them, are those with path[ray] == k. */
    size_t n_path;             /* distinct ones in this portion: some hundreds */
    const uint32_t *path_row;  /* [n_path] row of the dictionary */
    const uint16_t *path_rays; /* [n_path] */
    const uint16_t *path;      /* [n_ray] in [0, n_path) */

    /* ROWS */
    const uint32_t *segment_count;      /* [n_ray] */
    const uint32_t *registration_count; /* [n_ray], or NULL: no registrations at all */
    size_t n_kind;                      /* distinct (source, stop) of rays */
    const int32_t *kind_source;         /* [n_kind] */
    const uint8_t *kind_stop;           /* [n_kind] */
    const uint16_t *kind;               /* [n_ray] in [0, n_kind), or NULL: all are of kind 0 */
    size_t n_local;                     /* distinct classes of segments in this portion */
    const uint16_t *local_class;        /* [n_local] number of the class in the index */
    const uint32_t *local_rows;         /* [n_local] segments of that class */

    struct rmap_history_rows *rows; /* how classes are stored, and buffers; owned */
};

/* What an open view made of its portion, with the bytes unless they are in memory with the index,
 * as a block that may be kept beyond it: this, then arrays, no pointers. What is not there yet is
 * made when first asked for, in its place. */
struct rmap_history_made {
    uint64_t nbytes; /* of the block */
    uint8_t has_rare, is_ranked, zero[6];
};

/* A ray of a portion: its row, and where its segments and registrations begin. */
struct rmap_history_place_of_ray {
    uint32_t ray, segment, registration;
};

/* ---- making one ---- */

/* What values may be, [0, n) each (objects and media from -1): those of the map's scene. */
struct rmap_history_limits {
    size_t n_source, n_object, n_medium, n_detector;
};

/* An index as bytes: a head, which is held in memory, and the portions' bytes, which views read one
 * portion at a time. */
struct rmap_history_bytes {
    uint8_t *head, *body; /* rmap_free */
    size_t head_nbytes, body_nbytes;
};

/* Where a view finds the body. Either it is in memory (bytes), or `read` copies nbytes from
 * `offset` of it to `to`, from any thread. release: called with context when the index goes; both
 * may be NULL. */
struct rmap_history_body {
    const uint8_t *bytes;
    uint64_t nbytes;
    void *context;
    enum rmap_status (*read)(void *context, uint64_t offset, size_t nbytes, void *to,
                             struct rmap_error *err);
    void (*release)(void *context);
};

/* An index from its bytes, which are untrusted; the head is copied as needed. The body is taken
 * over on success alone. RMAP_FORMAT says what does not hold; RMAP_SYSTEM. */
enum rmap_status rmap_history_open(const uint8_t *head, size_t head_nbytes,
                                   const struct rmap_history_body *body,
                                   const struct rmap_history_limits *limits,
                                   struct rmap_history_index **index_ret,
                                   struct rmap_error *err) RMAP_MUST_USE;

#endif
