/* SPDX-License-Identifier: MIT
 *
 * Which values a scale of false colours goes over.
 */
#ifndef RMAP_VALUE_SCALE_H
#define RMAP_VALUE_SCALE_H

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

/* AUTO: logarithmic where most of what is lit would be dark on a linear scale, as ghosts beside an
 * image of the sun. */
enum rmap_figure_scale { RMAP_SCALE_AUTO, RMAP_SCALE_LINEAR, RMAP_SCALE_LOGARITHMIC };

/* A logarithmic scale of true colours goes down to this part of the largest value. */
#define RMAP_LOG_DEPTH 1e-5

/* Whether values [n], none below 0, are shown on a logarithmic scale that ends with `top`.
 * RMAP_SYSTEM. */
enum rmap_status rmap_value_scale_choose(const double *value, size_t n, double top,
                                         enum rmap_figure_scale asked, bool *logarithmic_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* The range that it has, then: range[1] > range[0]. */
void rmap_value_scale_find(const double *value, size_t n, double top, bool logarithmic,
                           double range[2]);

/* Cells that are so small that one ray makes them bright: the scale ends with the cell that is
 * brightest for sure, three standard errors less counted, and its error. */
double rmap_value_scale_sure(const double *value, const double *standard_error, size_t n,
                             double peak);

/* The value that so large a part of those above 0 lies below; 0: none is. Sorts `value`. */
double rmap_value_quantile(double *value, size_t n, double part);

#endif
