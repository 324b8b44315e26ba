/* SPDX-License-Identifier: MIT
 *
 * About the angles under which detectors were reached: a quarter of a degree that each lies in,
 * behind the lanes of pool16, before lengths of own paths.
 *
 * Rows of n registrations: their whole degrees, two to a row, the first in its lower byte, 255
 * where nothing is said; then their quarters, eight to a row, the first in its lowest bits.
 */
#ifndef RMAP_COMPACT_ANGLES_H
#define RMAP_COMPACT_ANGLES_H

#include <stdbool.h>

#include "portion/portion.h"
#include "scene/scene.h"

/* Quarters up to 180 degrees; and what says nothing. */
enum { RMAP_ANGLE_MAX = 4 * 180, RMAP_ANGLE_NONE = 4 * 255 };

static inline size_t rmap_angle_rows(size_t n)
{
    return (n + 1) / 2 + (n + 7) / 8;
}

/* The quarter of a degree in which light that goes in this direction meets the detector, the same
 * on every machine. direction: [3]. */
uint16_t rmap_angle_quarter(const struct rmap_detector *detector, const float *direction);

/* Between which angles that is, in degrees, whatever they are computed with: false where it says
 * nothing. */
bool rmap_angle_bounds(uint16_t quarter, double bound[2]);

/* Whether it does, or nothing is said. */
bool rmap_angle_is_in(uint16_t quarter, const struct rmap_detector *detector,
                      const float *direction);

/* row: [rmap_angle_rows(n)] of quarter [n], and back; what is no angle becomes RMAP_ANGLE_NONE. */
void rmap_angles_pack(const uint16_t *quarter, size_t n, uint16_t *row);
void rmap_angles_unpack(const uint16_t *row, size_t n, uint16_t *quarter);

#endif
