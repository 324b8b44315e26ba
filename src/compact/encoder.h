/* SPDX-License-Identifier: MIT
 *
 * A portion being encoded, for the files that do it.
 */
#ifndef RMAP_COMPACT_ENCODER_H
#define RMAP_COMPACT_ENCODER_H

#include "compact/few.h"
#include "compact/path_book.h"
#include "compact/settle.h"
#include "compact/step_codes.h"

struct rmap_compact_encoder {
    const struct rmap_compact_model *model;
    struct rmap_lane lane[RMAP_LANE_COUNT];
    struct rmap_lane_store store;
    uint64_t seed, first_ray;
    size_t n_ray, n_segment, n_registration, n_word; /* of the parts taken so far */

    /* [n_ray] */
    size_t cap_path, cap_channel, cap_hash, cap_begin, cap_length;
    uint32_t *path;
    uint8_t *channel;
    uint64_t *hash;
    size_t *begin;       /* of the path's words */
    double (*length)[2]; /* path and optical path */

    uint32_t *word;
    size_t cap_word;
    struct rmap_step_classes steps; /* met so far, numbered as they came */
    uint32_t *step;                 /* class of each segment, [n_segment], by these numbers; */
    uint32_t *class_of;             /* [steps.n] and by those of the piece in hand, where known; */
    uint32_t *own_class;            /* of the segments of own paths, by those of the piece */
    double *own_length;             /* of the rays with own paths */
    size_t cap_step, cap_class_of, cap_own_class, cap_own_length;
    struct rmap_step_coder coder;
    enum rmap_status status; /* RMAP_SYSTEM once memory ran short for them */
    uint32_t *triangle;
    size_t n_triangle, cap_triangle;
    uint16_t *angle; /* [n_registration] */
    size_t cap_angle;
    int16_t *medium; /* expected, [segments of the part in hand] */
    size_t cap_medium;
    struct rmap_path_rows own, entered;
    struct rmap_curve_columns curve; /* as they are */
    size_t n_curve, cap_ray, cap_segment, cap_position;
    struct rmap_batch batch;
    struct rmap_portion *predicted;
    struct rmap_few *few;
};

/* Words, hashes and expected media of the rays of a part. */
void rmap_encode_spell(struct rmap_compact_encoder *encoder, const struct rmap_portion *part);

/* Lists the triangles and offers what needs no segment traced. all: the part is the portion. */
void rmap_encode_lanes(struct rmap_compact_encoder *encoder, const struct rmap_portion *part,
                       bool all);

/* Looks the paths up and enters new ones, in the order of the calls: under the piece's lock.
 * *rows: to be appended to the piece, borrowed from the encoder until its next encode; the rows of
 * the whole tables are those that this portion adds. */
enum rmap_status rmap_compact_resolve(struct rmap_compact_encoder *encoder,
                                      struct rmap_path_book *book, struct rmap_rows *rows,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
