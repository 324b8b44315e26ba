/* SPDX-License-Identifier: MIT
 *
 * An image of a plane as lighting programs hand it in: the values at the points of a grid, their
 * average, least, greatest and uniformities, and how far the points may be apart.
 *
 * EN 12464-1:2021, 4.4: p = 0.2 5^(lg d) metres at most, and 10; d is the longer side of the area,
 * or the shorter one where the longer is twice that or more. There are d / p points along it,
 * rounded, and across so many as make the cells most nearly square. Here a value is the mean over
 * the cell about its point.
 */
#ifndef RMAP_LUX_TABLE_H
#define RMAP_LUX_TABLE_H

#include "analysis/detector/detector_image.h"

struct rmap_lux_grid {
    double d_m, most_m; /* EN 12464-1's d and p */
    uint32_t n[2];      /* points that it asks for along x and y, at least */
};

/* Of an area of these sides in metres. */
void rmap_lux_grid_find(const double size_m[2], struct rmap_lux_grid *grid);

/* The bins, over an area, get that many cells. */
void rmap_lux_grid_bins(struct rmap_detector_bins *bins);

/* As lighting programs round values: to three digits, from 100 on to whole numbers. */
void rmap_lux_text(double value, char text[32]);

/* Of an image over an area whose uniformity was found: columns by x, rows by y from the greatest
 * down; with --frame world in the world's where the axes lie along those. For people, as CSV (what
 * is no number in lines of "# key: value"), and added to a document as "table" and "grid". */
enum rmap_status rmap_lux_table_print(const struct rmap_detector_image *image, FILE *out,
                                      struct rmap_error *err) RMAP_MUST_USE;
void rmap_lux_table_csv(const struct rmap_detector_image *image, const char *criterion, FILE *out);
void rmap_lux_table_json(const struct rmap_detector_image *image, json_t *document);

#endif
