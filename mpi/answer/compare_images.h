/* SPDX-License-Identifier: MIT
 *
 * What differs between the images of a detector.
 */
#ifndef RMAP_COMPARE_IMAGES_H
#define RMAP_COMPARE_IMAGES_H

#include "mpi/answer/compare_fields.h"

/* Collective. detector: its name; NULL: the scene's only one. *bins_ret: on rank 0, NULL on the
 * others. Where none is named of several: RMAP_USAGE, or with may_be_none none. */
enum rmap_status rmap_compare_images_run(const struct rmap_context *context,
                                         const struct rmap_compare_samples *samples,
                                         const char *detector, bool may_be_none,
                                         const struct rmap_comparison *comparison,
                                         struct rmap_compare_bins **bins_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;

#endif
