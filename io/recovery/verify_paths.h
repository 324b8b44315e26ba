/* SPDX-License-Identifier: MIT
 *
 * Whether a piece counts its rays by paths as its portions do.
 */
#ifndef RMAP_VERIFY_PATHS_H
#define RMAP_VERIFY_PATHS_H

#include "io/recovery/verify.h"

/* Uses HDF5. Says nothing where portions cannot be read: their chunks are told of by themselves. */
enum rmap_status rmap_verify_path_rays(struct rmap_verification *self, size_t piece,
                                       struct rmap_findings *findings,
                                       struct rmap_error *err) RMAP_MUST_USE;

#endif
