/* SPDX-License-Identifier: MIT
 *
 * The file of a piece: that it is there, whole, sealed, itself, and of one mind with the index.
 */
#ifndef RMAP_VERIFY_PIECE_H
#define RMAP_VERIFY_PIECE_H

#include "io/recovery/verify.h"

/* The file of piece `piece` of self->claimed and its tables against the index. Uses HDF5: one
 * thread of a process at a time. */
enum rmap_status rmap_verify_piece(struct rmap_verification *self, size_t piece,
                                   struct rmap_findings *findings,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* Stored chunk `chunk` of self->content: XXH3-64 and fletcher32. Any thread, with a reader of its
 * own. Chunks of pieces that are gone are passed over. */
struct rmap_chunk_verifier;
enum rmap_status rmap_chunk_verifier_create(struct rmap_verification *verification,
                                            struct rmap_chunk_verifier **self_ret,
                                            struct rmap_error *err) RMAP_MUST_USE;
void rmap_chunk_verifier_destroy(struct rmap_chunk_verifier *self);
enum rmap_status rmap_verify_chunk(struct rmap_chunk_verifier *self, size_t chunk,
                                   struct rmap_findings *findings,
                                   struct rmap_error *err) RMAP_MUST_USE;

#endif
