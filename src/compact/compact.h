/* SPDX-License-Identifier: MIT
 *
 * The compact encoding: portions into rows of compact streams and back, bit for bit. No files.
 *
 * A map keeps the scene and the seed, so nearly everything of a ray follows from its PATH (which
 * objects it met and what happened there): the decoder traces the ray again, but is told which
 * surface comes next and never searches. Every number so predicted is compared with the true one
 * when it is written, and stored where it differs; a portion that the model does not describe is
 * stored as it is. docs/encoding.md has streams and formulas.
 *
 * All of it uses +, -, x, / and square roots of doubles in a fixed order, so that every machine
 * decodes the same bits.
 */
#ifndef RMAP_COMPACT_H
#define RMAP_COMPACT_H

#include <stdbool.h>

#include "base/status.h"
#include "compact/layout.h"
#include "portion/portion.h"
#include "scene/scene.h"

/* Constant, the same for both modes. What rmap_layout_of(RMAP_ENCODING_COMPACT, mode) is. */
extern const struct rmap_layout rmap_compact_layout;

/* What predictions need of a scene in one colour space. Immutable, thread-safe. The scene is
 * borrowed and must outlive it. RMAP_SYSTEM when memory is short. */
struct rmap_compact_model;

struct rmap_path_book;

/* One per thread; the model is borrowed. */
struct rmap_compact_encoder;
enum rmap_status rmap_compact_encoder_create(const struct rmap_compact_model *model,
                                             struct rmap_compact_encoder **encoder_ret,
                                             struct rmap_error *err) RMAP_MUST_USE;
void rmap_compact_encoder_destroy(struct rmap_compact_encoder *encoder);

/* Everything but the references to paths; outside every lock. The portion has all columns and the
 * model's channels; it may change as soon as this returns. seed: that its rays were traced with (a
 * wrong one costs bytes, nothing else). Any contents are encoded; RMAP_INTERNAL only when the
 * counts do not sum up to the rows. */
enum rmap_status rmap_compact_encode(struct rmap_compact_encoder *encoder, uint64_t seed,
                                     const struct rmap_portion *portion,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* The same in parts, in the order of their ids, none of which need stay: for rays that nearly all
 * are predicted (struct rmap_portion.unpredicted) and have consecutive ids. *whole_ret: they are
 * not, and the portion must be encoded in one after all. RMAP_SYSTEM, or RMAP_INTERNAL as above. */
bool rmap_compact_in_parts(const struct rmap_compact_model *model); /* whether that may work */
void rmap_compact_encode_begin(struct rmap_compact_encoder *encoder, uint64_t seed,
                               uint64_t first_ray);
enum rmap_status rmap_compact_encode_part(struct rmap_compact_encoder *encoder,
                                          const struct rmap_portion *part, bool *whole_ret,
                                          struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_compact_encode_end(struct rmap_compact_encoder *encoder, bool *whole_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;

struct rmap_path_table;

/* One per thread; the model is borrowed. */
struct rmap_compact_decoder;
enum rmap_status rmap_compact_decoder_create(const struct rmap_compact_model *model,
                                             struct rmap_compact_decoder **decoder_ret,
                                             struct rmap_error *err) RMAP_MUST_USE;
void rmap_compact_decoder_destroy(struct rmap_compact_decoder *decoder);

/* Rays i of what is decoded from now on with mark[i] != 0 are of no interest: columns for which
 * rays are traced again may have anything there, though nothing that leads out of a table. mark:
 * [n_ray], borrowed until it is set again; NULL: all are. */
void rmap_compact_decoder_pass_over(struct rmap_compact_decoder *decoder, const uint8_t *mark);

/* A portion's rows (the streams named by rmap_compact_streams, of its own rows) into the columns
 * asked for; what else `out` has stays undefined. n_row: rows that the index promises per logical
 * table; anything else in the rows is RMAP_FORMAT, found before memory is asked for. Every value
 * of the rows is untrusted. present: columns that `out` has of the same rows, by calls before: they
 * stay. 0: it is emptied first. Its channels are the model's. */
enum rmap_status rmap_compact_decode(struct rmap_compact_decoder *decoder,
                                     const struct rmap_path_table *table,
                                     const struct rmap_rows *rows,
                                     const size_t n_row[RMAP_TABLE_COUNT], rmap_column_set columns,
                                     rmap_column_set present, struct rmap_portion *out,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* What the rays of a portion are known by, without going through their segments. */
struct rmap_compact_summary {
    const uint32_t *path; /* [n_ray] 1 + row of the table; 0: the next of its own; borrowed from the
                             rows, and NULL where they are not there */
    size_t n_own;         /* rays with a path of their own, */
    size_t n_own_segment; /* and their segments */
    bool weigh_one;       /* each weighs 1 */
    bool ids_run;         /* row i has the id first_ray + i */
    bool media_known;     /* media are those that the paths say */
    bool placed;          /* places of registrations stand by themselves */
    bool classed;         /* segments of own paths are stored as classes of steps, */
    size_t n_code;        /* which have so many codes; 0: none */
    bool angled;          /* angles of registrations are known, about, */
    bool measured;        /* and lengths of own paths, */
    bool arrives;         /* and the paths of the rays that arrive (src/compact/arrivals.h), */
    size_t n_arrival;     /* so many */
    uint64_t first_ray;
};

#endif
