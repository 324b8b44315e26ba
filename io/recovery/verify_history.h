/* SPDX-License-Identifier: MIT
 *
 * Whether history indexes are sound, and say of the rays what the columns say.
 */
#ifndef RMAP_VERIFY_HISTORY_H
#define RMAP_VERIFY_HISTORY_H

#include "io/recovery/verify.h"

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
