/* SPDX-License-Identifier: MIT
 *
 * For the files that make up verifying.
 */
#ifndef RMAP_VERIFY_INTERNAL_H
#define RMAP_VERIFY_INTERNAL_H

#include "io/map/map_directory.h"
#include "io/map/map_format.h"
#include "io/recovery/verify.h"

/* Rays of all portions of a piece of a content. */
void rmap_finding_add_piece(struct rmap_finding *finding, const struct rmap_map_content *content,
                            size_t piece);

void rmap_finding_add_portion(struct rmap_finding *finding,
                              const struct rmap_portion_info *portion);

/* Sets flags of a piece, of a portion. Any thread. */
void rmap_verification_flag_piece(struct rmap_verification *self, size_t piece, int flag);
void rmap_verification_flag_portion(struct rmap_verification *self, size_t portion, int flag);

/* verify_files.c: one finding per shard directory that is not there; one per piece on disk, of
 * which the list is all, that the index of a complete map does not know. */
enum rmap_status rmap_verify_missing_shards(struct rmap_verification *self,
                                            struct rmap_findings *findings,
                                            struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_verify_extra_pieces(struct rmap_verification *self,
                                          const struct rmap_piece_name *name, size_t n,
                                          struct rmap_findings *findings,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* Findings for every dataset in which two lists of equal length differ; `file` says the first.
 * portion: whose rays they cost (NULL: none), row by row. */
struct rmap_table_pair {
    const char *file;
    const char *what; /* the other, "shard-00000/piece-00000.h5" */
    struct rmap_field_table table;
    const void *says, *is;
    size_t n, row_nbytes;
    const struct rmap_portion_info *portion;
};
enum rmap_status rmap_verify_tables(const struct rmap_table_pair *pair,
                                    struct rmap_findings *findings,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* What the index repeats of the scene inside, and of its pieces, for other readers. */
enum rmap_status rmap_verify_scene(struct rmap_verification *self, struct rmap_h5 *h5,
                                   struct rmap_findings *findings,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* The index's view of all pieces as one. */
enum rmap_status rmap_verify_view(struct rmap_verification *self, struct rmap_h5 *h5,
                                  struct rmap_findings *findings,
                                  struct rmap_error *err) RMAP_MUST_USE;

/* History indexes: the file of a piece's, if it has one (uses HDF5); what it says of a portion
 * whose columns are `rays` (any thread); and those without a piece, of which the list is all on
 * disk. */
enum rmap_status rmap_verify_history_file(struct rmap_verification *self, size_t piece,
                                          struct rmap_findings *findings,
                                          struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_verify_history(struct rmap_verification *self, size_t portion,
                                     const struct rmap_portion *rays,
                                     struct rmap_findings *findings,
                                     struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_verify_stray_histories(struct rmap_verification *self,
                                             const struct rmap_piece_name *piece, size_t n_piece,
                                             struct rmap_findings *findings,
                                             struct rmap_error *err) RMAP_MUST_USE;

#endif
