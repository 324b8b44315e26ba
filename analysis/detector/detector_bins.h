/* SPDX-License-Identifier: MIT
 *
 * Into which cell of a picture what a detector registered falls: its own cells as they were
 * recorded, or any others, over its area or over the directions of the light.
 *
 * u and v: over the area x and y in the scene's unit, in axes turned counterclockwise by `rotate`
 * about the detector's centre; over directions theta from the detector's axis and phi about it (of
 * where the light comes from for a plane, of where it goes for an intensity grid), in radians, phi
 * counted from `rotate`. Of a camera the tangents of where it comes from, to the right and upwards,
 * as seen from the middle of its opening through a place on the plane in focus.
 */
#ifndef RMAP_DETECTOR_BINS_H
#define RMAP_DETECTOR_BINS_H

#include <stdbool.h>
#include <stdint.h>

#include "portion/portion.h"
#include "scene/scene.h"

enum rmap_detector_quantity {
    RMAP_PER_AREA,           /* flux per area: illuminance */
    RMAP_PER_SOLID_ANGLE,    /* flux per solid angle */
    RMAP_PER_AREA_AND_ANGLE, /* flux per area, solid angle and cosine: luminance */
    RMAP_PER_CELL            /* per cell */
};

struct rmap_detector_bins {
    const struct rmap_detector *detector;
    double unit_m;
    enum rmap_detector_quantity quantity;
    bool stored;     /* the detector's own cells */
    bool directions; /* over directions, else over the area */
    bool camera;     /* neither: a camera's picture */
    uint32_t n[2];
    double low[2], high[2]; /* of u and v */
    double rotate_rad, cosine, sine;
};

/* What was asked for; zero and NULL: not. */
struct rmap_detector_bins_asked {
    uint32_t cells[2];
    const char *region;   /* "x0,y0,x1,y1", units allowed; over directions theta and phi */
    bool world;           /* the region is told in the world */
    double rotate_deg;    /* NaN: not given */
    const char *quantity; /* "illuminance" ... */
    const char *over;     /* "area", "direction" */
};

#define RMAP_DETECTOR_CELLS_MAX (1u << 26)

/* The detector's own. */
void rmap_detector_bins_own(const struct rmap_scene *scene, int32_t detector,
                            struct rmap_detector_bins *bins);

/* RMAP_USAGE with the reason and the remedy. Without a region all of the detector is covered. */
enum rmap_status rmap_detector_bins_read(const struct rmap_scene *scene, int32_t detector,
                                         const struct rmap_detector_bins_asked *asked,
                                         struct rmap_detector_bins *bins,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* Columns of /registration that say the cell. */
rmap_column_set rmap_detector_bins_columns(const struct rmap_detector_bins *bins);

/* Cell i + n[0] j of row `row` of /registration; SIZE_MAX: beside the region. A stored cell that
 * the detector has not is SIZE_MAX - 1. */
size_t rmap_detector_bins_cell(const struct rmap_detector_bins *bins,
                               const struct rmap_portion *portion, size_t row);

/* x and y on the detector of what was registered, in the scene's unit, from stored relative
 * coordinates (planes alone). */
void rmap_detector_bins_place(const struct rmap_detector_bins *bins,
                              const struct rmap_portion *portion, size_t row, double *x, double *y);

/* By what the flux of cell i + n[0] j, and of the whole region, is divided: m2, sr, m2 sr or 1. */
double rmap_detector_bins_extent(const struct rmap_detector_bins *bins, size_t cell);
double rmap_detector_bins_whole(const struct rmap_detector_bins *bins);

/* Centre of cell (i, j) in the detector's own coordinates: x, y, or theta and phi in degrees. */
void rmap_detector_bins_centre(const struct rmap_detector_bins *bins, uint32_t i, uint32_t j,
                               double *x, double *y);

#endif
