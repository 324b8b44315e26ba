/* SPDX-License-Identifier: MIT
 *
 * Units of a detector's values: of flux per area, solid angle, both, or cell.
 */
#ifndef RMAP_IMAGE_UNIT_H
#define RMAP_IMAGE_UNIT_H

#include <stdbool.h>

#include "analysis/detector/detector_bins.h"
#include "base/status.h"
#include "base/unit.h"

struct rmap_image_unit {
    enum rmap_detector_quantity quantity;
    enum rmap_flux_unit flux;
    const char *name;
    double size; /* in the first unit of its kind, as W/m2 or lx */
};

/* The one that values are in where nobody says. Constant. */
const struct rmap_image_unit *rmap_image_unit_usual(enum rmap_detector_quantity quantity,
                                                    enum rmap_flux_unit flux);

/* The one of this name; NULL: the usual one. RMAP_USAGE with those that fit. */
enum rmap_status rmap_image_unit_find(enum rmap_detector_quantity quantity,
                                      enum rmap_flux_unit flux, const char *name,
                                      const struct rmap_image_unit **unit_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
