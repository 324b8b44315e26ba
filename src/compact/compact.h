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
enum rmap_status rmap_compact_model_create(const struct rmap_scene *scene,
                                           struct rmap_compact_model **model_ret,
                                           struct rmap_error *err) RMAP_MUST_USE;
void rmap_compact_model_destroy(struct rmap_compact_model *model);

/* The paths that rays of a piece may refer to, as they are appended to it. One per piece; used
 * under the lock that orders the appends. */
struct rmap_path_book;
enum rmap_status rmap_path_book_create(struct rmap_path_book **book_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;
void rmap_path_book_destroy(struct rmap_path_book *book);

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
 * are foretold (struct rmap_portion.strays) and have consecutive ids. *whole_ret: they are not, and
 * the portion must be encoded in one after all. RMAP_SYSTEM, or RMAP_INTERNAL as above. */
bool rmap_compact_in_parts(const struct rmap_compact_model *model); /* whether that may work */
void rmap_compact_encode_begin(struct rmap_compact_encoder *encoder, uint64_t seed,
                               uint64_t first_ray);
enum rmap_status rmap_compact_encode_part(struct rmap_compact_encoder *encoder,
                                          const struct rmap_portion *part, bool *whole_ret,
                                          struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_compact_encode_end(struct rmap_compact_encoder *encoder, bool *whole_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* Looks the paths up and enters new ones, in the order of the calls: under the piece's lock.
 * *rows: to be appended to the piece, borrowed from the encoder until its next encode; the rows of
 * the whole tables are those that this portion adds. */
enum rmap_status rmap_compact_resolve(struct rmap_compact_encoder *encoder,
                                      struct rmap_path_book *book, struct rmap_rows *rows,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* The paths of a piece being read, from all rows of its whole tables (other streams may be NULL);
 * copied. Immutable. RMAP_FORMAT when the rows do not fit together. */
struct rmap_path_table;
enum rmap_status rmap_path_table_create(const struct rmap_compact_model *model,
                                        const struct rmap_rows *rows,
                                        struct rmap_path_table **table_ret,
                                        struct rmap_error *err) RMAP_MUST_USE;
void rmap_path_table_destroy(struct rmap_path_table *table);
size_t rmap_path_table_nbytes(const struct rmap_path_table *table); /* of memory */

/* The paths as rays of a portion, with columns RMAP_COLUMNS_DISCRETE; the others are NULL. Borrowed
 * from the table. Values are as untrusted as the rows. */
const struct rmap_portion *rmap_path_table_rays(const struct rmap_path_table *table);

/* [its rays] the first of each one's rows. */
const uint32_t *rmap_path_table_first_segments(const struct rmap_path_table *table);
const uint32_t *rmap_path_table_first_registrations(const struct rmap_path_table *table);

/* Streams (bit s: stream s of the layout) that decoding these columns needs, without those of the
 * whole tables. */
uint64_t rmap_compact_streams(rmap_column_set columns);

/* One per thread; the model is borrowed. */
struct rmap_compact_decoder;
enum rmap_status rmap_compact_decoder_create(const struct rmap_compact_model *model,
                                             struct rmap_compact_decoder **decoder_ret,
                                             struct rmap_error *err) RMAP_MUST_USE;
void rmap_compact_decoder_destroy(struct rmap_compact_decoder *decoder);

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

/* Whether rays must be traced again for these columns, which takes longest by far. */
bool rmap_compact_retraces(rmap_column_set columns);

/* What the rays of a portion are known by, without going through their legs. */
struct rmap_compact_told {
    const uint32_t *path; /* [n_ray] 1 + row of the table; 0: the next of its own; borrowed from the
                             rows */
    size_t n_own;         /* rays with a path of their own */
    bool weigh_one;       /* each weighs 1 */
    bool ids_run;         /* row i has the id first_ray + i */
    bool media_told;      /* media are those that the paths say */
    uint64_t first_ray;
};

/* What the portion's header says of it: all but path and n_own. Its stream, and RMAP_FORMAT where
 * there is none. */
uint64_t rmap_compact_header_streams(void);
enum rmap_status rmap_compact_tell_header(const struct rmap_rows *rows,
                                          struct rmap_compact_told *told,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* Streams that the next two need. */
uint64_t rmap_compact_told_streams(void);

/* rows, n_row: as for decoding, by which RMAP_FORMAT is told here, too. */
enum rmap_status
rmap_compact_tell(const struct rmap_compact_model *model, const struct rmap_path_table *table,
                  const struct rmap_rows *rows, const size_t n_row[RMAP_TABLE_COUNT],
                  struct rmap_compact_told *told, struct rmap_error *err) RMAP_MUST_USE;

/* The rays with paths of their own, side by side, of rows that were told of: columns
 * RMAP_COLUMNS_DISCRETE, media as the paths say; and room for id and weight. out: emptied first. */
enum rmap_status rmap_compact_decode_own(const struct rmap_compact_model *model,
                                         const struct rmap_rows *rows, struct rmap_portion *out,
                                         struct rmap_error *err) RMAP_MUST_USE;

#endif
