/* SPDX-License-Identifier: MIT
 *
 * The angle under which a detector is reached, and whether it lies in an interval: told without
 * its arc where it is clear of both ends.
 */
#ifndef RMAP_REGISTRATION_ANGLE_H
#define RMAP_REGISTRATION_ANGLE_H

#include "analysis/criterion/criterion_evaluate.h"
#include "compact/angles.h"

/* Degrees between the axis and the reversed ray, or, on an intensity grid, the ray itself. */
double rmap_registration_angle(const struct rmap_detector *detector, const float *direction);

/* The ends of the interval as directions, for the next. */
void rmap_angle_ends_set(struct rmap_angle_ends *ends, const struct rmap_interval *interval);

/* As rmap_interval_holds says of rmap_registration_angle. */
bool rmap_angle_holds(const struct rmap_detector *detector, const float *direction,
                      const struct rmap_interval *interval, const struct rmap_angle_ends *ends);

_Static_assert(RMAP_OUTCOME_NO == 0 && RMAP_OUTCOME_OPEN == 1 && RMAP_OUTCOME_YES == 3,
               "outcomes are bits");

/* What is known of that where only the quarter of a degree is: enum rmap_outcome. */
static inline uint8_t rmap_angle_outcome(uint16_t quarter, const struct rmap_interval *interval,
                                         const struct rmap_angle_ends *ends)
{
    /* without a branch: angles are random */
    const unsigned near = (uint16_t)(quarter - ends->first_near) < ends->n_near;
    const unsigned inside = (uint16_t)(quarter - ends->first_inside) < ends->n_inside;
    const unsigned within = near + 2 * (near & inside); /* NO, OPEN, YES */
    const unsigned outcome = interval->outside ? rmap_outcome_not((uint8_t)within) : within;
    return (uint8_t)(quarter > RMAP_ANGLE_MAX ? RMAP_OUTCOME_OPEN : outcome);
}

#endif
