/* SPDX-License-Identifier: MIT
 *
 * Whether what a piece says of its rays by their paths is so.
 */
#ifndef RMAP_VERIFY_PATHS_H
#define RMAP_VERIFY_PATHS_H

#include "io/recovery/verify.h"

struct rmap_cursor;

/* Numbers of rays. Uses HDF5. Says nothing where portions cannot be read: their chunks are told of
 * by themselves. */
enum rmap_status rmap_verify_path_rays(struct rmap_verification *self, size_t piece,
                                       struct rmap_findings *findings,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Bounds of the rays of a portion that the cursor has just read. Any thread. */
enum rmap_status rmap_verify_path_bounds(struct rmap_verification *self, struct rmap_cursor *cursor,
                                         size_t portion, const struct rmap_portion *rays,
                                         struct rmap_findings *findings,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* What it says of the lengths of those with paths of their own. Likewise. */
enum rmap_status rmap_verify_own_lengths(struct rmap_verification *self, struct rmap_cursor *cursor,
                                         size_t portion, const struct rmap_portion *rays,
                                         struct rmap_findings *findings,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* Which of them it says arrive at detectors. Likewise. */
enum rmap_status rmap_verify_arrivals(struct rmap_verification *self, struct rmap_cursor *cursor,
                                      size_t portion, struct rmap_findings *findings,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* What it says of the angles of registrations. rays: with all columns. Likewise. */
enum rmap_status rmap_verify_angles(struct rmap_verification *self, size_t portion,
                                    const struct rmap_portion *rays, struct rmap_findings *findings,
                                    struct rmap_error *err) RMAP_MUST_USE;

#endif
