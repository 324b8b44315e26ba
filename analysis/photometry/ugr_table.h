/* SPDX-License-Identifier: MIT
 *
 * A luminaire's table of glare: UGR in 19 standard rooms of 5 reflectances, viewed crosswise and
 * endwise, as CIE 190:2010 sets it out, at a spacing of a quarter of the height.
 *
 * Luminaires fill the ceiling of a room X (across the line of sight) x Y (along it), each a quarter
 * of H apart; the eye is H = 2 m below them, in the middle of a wall. The background is E / pi of
 * the indirect light on the walls of the box between the eye and the luminaires. What the reference
 * plane gets directly is integrated over the intensities, for evenly spread luminaires (the
 * standard has factors of zones for it), and interreflection solved with the form factors of the
 * box, which gives the standard's table 5 to its three digits.
 */
#ifndef RMAP_UGR_TABLE_H
#define RMAP_UGR_TABLE_H

#include <jansson.h>
#include <stdio.h>

#include "scene/lamp.h"

enum { RMAP_UGR_ROOMS = 19, RMAP_UGR_SURFACES = 5, RMAP_UGR_COLUMNS = 2 * RMAP_UGR_SURFACES };

struct rmap_ugr_table {
    double value[RMAP_UGR_ROOMS][RMAP_UGR_COLUMNS]; /* crosswise, then endwise; NaN: no light */
};

/* Of so many lumens; unit_m: of the opening's lengths. False: it has no opening, so that nothing is
 * known of its luminance. */
bool rmap_ugr_table_find(const struct rmap_lamp *lamp, double lumens, double unit_m,
                         struct rmap_ugr_table *table);

void rmap_ugr_table_print(const struct rmap_ugr_table *table, FILE *out);
json_t *rmap_ugr_table_json(const struct rmap_ugr_table *table);

/* Shares of the flux that first falls on the floor, the walls and the ceiling of a box (x, y over
 * its height) that come to the walls after one reflection or more: FT,FW, FT,WW - 1 and FT,CW of
 * CIE 190, table 5. reflectance: of floor, walls, ceiling. */
void rmap_ugr_transfer(double x, double y, const double reflectance[3], double share[3]);

#endif
