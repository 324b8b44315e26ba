/* SPDX-License-Identifier: MIT
 *
 * About the angles under which detectors were reached: a quarter of a degree that each lies in.
 *
 * Whole degrees stand behind the lanes of pool32, four to a row, the first in its lowest byte, 255
 * where nothing is said: by themselves, since few of them are met often, which deflate makes use
 * of. Their quarters stand behind the lanes of pool16, before lengths of own paths, eight to a row,
 * the first in its lowest bits.
 */
#ifndef RMAP_COMPACT_ANGLES_H
#define RMAP_COMPACT_ANGLES_H

#include <stdbool.h>

#include "portion/portion.h"
#include "scene/scene.h"

/* Quarters up to 180 degrees; and what says nothing. */
enum { RMAP_ANGLE_MAX = 4 * 180, RMAP_ANGLE_NONE = 4 * 255 };

/* Rows of n registrations. */
struct rmap_angle_rows {
    const uint32_t *degrees; /* [rmap_angle_degree_rows(n)] */
    const uint16_t *parts;   /* [rmap_angle_part_rows(n)] */
};

static inline size_t rmap_angle_degree_rows(size_t n)
{
    return (n + 3) / 4;
}

static inline size_t rmap_angle_part_rows(size_t n)
{
    return (n + 7) / 8;
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

/* Rows of quarter [n] into room for them, and back. */
void rmap_angles_pack(const uint16_t *quarter, size_t n, uint32_t *degrees, uint16_t *parts);
void rmap_angles_unpack(const struct rmap_angle_rows *rows, size_t n, uint16_t *quarter);

#endif
