/* SPDX-License-Identifier: MIT
 *
 * The angle under which a detector is reached, and whether it lies in an interval: told without
 * its arc where it is clear of both ends.
 */
#ifndef RMAP_REGISTRATION_ANGLE_H
#define RMAP_REGISTRATION_ANGLE_H

#include "analysis/criterion/criterion_tree.h"

/* Degrees between the axis and the reversed ray, or, on an intensity grid, the ray itself. */
double rmap_registration_angle(const struct rmap_detector *detector, const float *direction);

/* The ends of the interval as directions, for the next. */
void rmap_angle_ends_set(struct rmap_angle_ends *ends, const struct rmap_interval *interval);

/* As rmap_interval_holds says of rmap_registration_angle. */
bool rmap_angle_holds(const struct rmap_detector *detector, const float *direction,
                      const struct rmap_interval *interval, const struct rmap_angle_ends *ends);

#endif
