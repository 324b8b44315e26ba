/* SPDX-License-Identifier: MIT
 *
 * The angle under which a detector is reached, and whether it lies in an interval: told without
 * its arc where it is clear of both ends.
 */
#include "analysis/criterion/registration_angle.h"

#include <math.h>

#include "scene/incidence.h"

/* atan2 keeps its digits near 0 and 180. */
static double degrees(struct rmap_tilt tilt)
{
    return atan2(tilt.across, tilt.along) * (180.0 / RMAP_PI);
}

double rmap_registration_angle(const struct rmap_detector *detector, const float *direction)
{
    return degrees(rmap_incidence(detector, direction));
}

static void set_end(double end[2], double deg)
{
    end[0] = cos(deg * (RMAP_PI / 180.0));
    end[1] = sin(deg * (RMAP_PI / 180.0));
}

/* Those inside, and those near, follow each other. */
static void set_quarters(struct rmap_angle_ends *ends, const struct rmap_interval *interval)
{
    const struct rmap_interval within = {.low = interval->low, .high = interval->high};
    ends->first_inside = ends->n_inside = ends->first_near = ends->n_near = 0;
    for (uint16_t quarter = RMAP_ANGLE_MAX + 1; quarter-- > 0;) {
        double bound[2];
        (void)rmap_angle_bounds(quarter, bound);
        const uint8_t outcome = rmap_bounds_outcome(&within, bound[0], bound[1]);
        if (outcome == RMAP_OUTCOME_NO)
            continue;
        ends->first_near = quarter;
        ends->n_near++;
        if (outcome == RMAP_OUTCOME_OPEN)
            continue;
        ends->first_inside = quarter;
        ends->n_inside++;
    }
}

void rmap_angle_ends_set(struct rmap_angle_ends *ends, const struct rmap_interval *interval)
{
    ends->is_set = interval->low <= 180.0 && interval->high >= 0.0;
    set_end(ends->low, fmax(interval->low, 0.0));
    set_end(ends->high, fmin(interval->high, 180.0));
    set_quarters(ends, interval);
}

/* 1 beyond an end, -1 before it, by the sine of the angle between them; 0: as near as rounding, or
 * not a number. */
static int compare_end(struct rmap_tilt tilt, const double end[2])
{
    const double close = 1e-9 * (tilt.across + fabs(tilt.along));
    double beyond = tilt.across * end[0] - tilt.along * end[1];
    return (beyond > close) - (beyond < -close);
}

bool rmap_angle_holds(const struct rmap_detector *detector, const float *direction,
                      const struct rmap_interval *interval, const struct rmap_angle_ends *ends)
{
    struct rmap_tilt tilt = rmap_incidence(detector, direction);
    int low = ends->is_set ? interval->low <= 0.0 ? 1 : compare_end(tilt, ends->low) : 0;
    int high = ends->is_set ? compare_end(tilt, ends->high) : 0;
    if (low == 0 || high == 0)
        return rmap_interval_holds(interval, degrees(tilt));
    return (low > 0 && high < 0) != interval->outside;
}
