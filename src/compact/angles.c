/* SPDX-License-Identifier: MIT
 *
 * About the angles under which detectors were reached.
 */
#include "compact/angles.h"

#include <math.h>
#include <string.h>

#include "base/portable.h"
#include "scene/incidence.h"

enum { DEGREES_PER_ROW = 4, PARTS_PER_ROW = 8 };

/* Degrees by which two ways to compute an angle differ at most, and far more. */
static const double slack = 1e-9;

/* In quarters; NaN of no direction. */
static double angle_of(const struct rmap_detector *detector, const float *direction)
{
    const struct rmap_tilt tilt = rmap_incidence(detector, direction);
    return tilt.across > 0.0 || tilt.along < 0.0 || tilt.along > 0.0
               ? rmap_portable_angle(tilt.along, tilt.across) * (RMAP_ANGLE_MAX / RMAP_PI)
               : (double)NAN;
}

uint16_t rmap_angle_quarter(const struct rmap_detector *detector, const float *direction)
{
    const double quarters = angle_of(detector, direction);
    return quarters >= 0.0 && quarters <= RMAP_ANGLE_MAX ? (uint16_t)quarters : RMAP_ANGLE_NONE;
}

bool rmap_angle_is_in(uint16_t quarter, const struct rmap_detector *detector,
                      const float *direction)
{
    double bound[2];
    const double degrees = angle_of(detector, direction) / 4.0;
    return !rmap_angle_bounds(quarter, bound) || (degrees >= bound[0] && degrees <= bound[1]);
}

bool rmap_angle_bounds(uint16_t quarter, double bound[2])
{
    bound[0] = quarter / 4.0 - slack;
    bound[1] = (quarter + 1) / 4.0 + slack;
    return quarter <= RMAP_ANGLE_MAX;
}

void rmap_angles_pack(const uint16_t *quarter, size_t n, uint32_t *degrees, uint16_t *parts)
{
    memset(degrees, 0, rmap_angle_degree_rows(n) * sizeof *degrees);
    memset(parts, 0, rmap_angle_part_rows(n) * sizeof *parts);
    for (size_t i = 0; i < n; i++) {
        degrees[i / DEGREES_PER_ROW] |= (uint32_t)quarter[i] / 4 << 8 * (i % DEGREES_PER_ROW);
        parts[i / PARTS_PER_ROW] |= (uint16_t)(quarter[i] % 4 << 2 * (i % PARTS_PER_ROW));
    }
}

void rmap_angles_unpack(const struct rmap_angle_rows *rows, size_t n, uint16_t *quarter)
{
    for (size_t i = 0; i < n; i++) {
        const unsigned whole = rows->degrees[i / DEGREES_PER_ROW] >> 8 * (i % DEGREES_PER_ROW);
        const unsigned part = rows->parts[i / PARTS_PER_ROW] >> 2 * (i % PARTS_PER_ROW);
        quarter[i] = (uint16_t)(4 * (whole & 0xff) + (part & 3));
    }
}
