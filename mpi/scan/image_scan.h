/* SPDX-License-Identifier: MIT
 *
 * A detector's sums over the rays that match a criterion, portions scattered over ranks and
 * threads.
 */
#ifndef RMAP_IMAGE_SCAN_H
#define RMAP_IMAGE_SCAN_H

#include "analysis/detector/detector_sums.h"
#include "mpi/command/command.h"

/* Collective. Adds to sums, which every rank has initialised alike; complete on rank 0 alone. */
enum rmap_status rmap_image_scan(const struct rmap_context *context, const struct rmap_map *map,
                                 const struct rmap_choice *choice, struct rmap_detector_sums *sums,
                                 struct rmap_error *err) RMAP_MUST_USE;

#endif
