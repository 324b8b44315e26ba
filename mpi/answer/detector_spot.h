/* SPDX-License-Identifier: MIT
 *
 * The spot on a detector: size, encircled energy and MTF, of places that are read pass by pass.
 */
#ifndef RMAP_DETECTOR_SPOT_H
#define RMAP_DETECTOR_SPOT_H

#include "analysis/detector/detector_image.h"
#include "analysis/detector/spot.h"
#include "mpi/answer/detector_request.h"
#include "mpi/scan/image_scan.h"

/* Collective. More passes over the registrations, about the centre that the image found; *spot is
 * rank 0's, and the caller's whatever happened. image: of rank 0. */
enum rmap_status rmap_detector_spot_find(const struct rmap_context *context,
                                         const struct rmap_detector_request *request,
                                         const struct rmap_detector_ask *image_ask,
                                         const struct rmap_choice *choice,
                                         const struct rmap_detector_image *image,
                                         struct rmap_spot **spot,
                                         struct rmap_error *err) RMAP_MUST_USE;

#endif
