/* SPDX-License-Identifier: MIT
 *
 * An index in the making.
 */
#ifndef RMAP_HISTORY_BUILDER_H
#define RMAP_HISTORY_BUILDER_H

#include "history/history_parts.h"
#include "history/word_book.h"

/* A ray's words: these, then the classes of its segments, the segments of its registrations, their
 * hits. */
enum {
    RMAP_HISTORY_WORD_SOURCE,
    RMAP_HISTORY_WORD_STOP,
    RMAP_HISTORY_WORD_SEGMENTS,
    RMAP_HISTORY_WORD_REGISTRATIONS,
    RMAP_HISTORY_WORD_HEAD
};

/* Distinct classes of a portion, the most frequent first. */
struct rmap_history_tally {
    uint32_t class_number, rows;
};

struct rmap_history_builder {
    struct rmap_word_book class_of, hit, path; /* of the piece */
    size_t n_path_segment, n_path_registration;
    struct rmap_history_place *place;
    size_t n_place, cap_place;
    uint8_t *body;
    size_t body_nbytes, cap_body;

    /* Of the portion in hand. */
    const struct rmap_portion *portion;
    struct rmap_word_book distinct, kind;
    uint32_t *row_class, *row_hit, *ray_path,
        *ray_kind; /* numbers in class_of, hit, distinct, kind */
    size_t cap_row_class, cap_row_hit, cap_ray_path, cap_ray_kind;
    uint32_t *word; /* of a ray */
    size_t cap_word;
    struct rmap_history_tally *tally; /* [n_tally] */
    size_t n_tally, cap_tally;
    uint32_t *local_of; /* [cap_local_of] by class: rows of it, then its local number */
    size_t cap_local_of;
};

/* The portions of one piece, by first ray, with RMAP_HISTORY_COLUMNS. Memory: that of the index. */
enum rmap_status rmap_history_builder_create(struct rmap_history_builder **builder_ret,
                                             struct rmap_error *err) RMAP_MUST_USE;
void rmap_history_builder_destroy(struct rmap_history_builder *builder);
enum rmap_status rmap_history_builder_add(struct rmap_history_builder *builder,
                                          const struct rmap_portion *portion,
                                          struct rmap_digest digest,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* The builder is empty afterwards. */
enum rmap_status rmap_history_builder_finish(struct rmap_history_builder *builder,
                                             struct rmap_history_bytes *bytes,
                                             struct rmap_error *err) RMAP_MUST_USE;

#endif
