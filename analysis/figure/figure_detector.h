/* SPDX-License-Identifier: MIT
 *
 * The picture of a detector: its image in false colour with a scale, or in true colour, with
 * axes in the detector's own units. PLANE: x to the right, y upwards; INTENSITY: phi to the
 * right, theta upwards.
 */
#ifndef RMAP_FIGURE_DETECTOR_H
#define RMAP_FIGURE_DETECTOR_H

#include "analysis/detector/detector_image.h"
#include "analysis/figure/value_scale.h"
#include "io/export/svg.h"

struct rmap_figure_detector {
    const char *criterion;        /* NULL: all rays */
    bool true_colour;             /* the image must have rgb */
    double white;                 /* in true colour the value shown as white; 0: chosen */
    enum rmap_figure_scale scale; /* AUTO: in true colours linear */
    const char *sums;             /* what is said in place of registrations and flux; NULL: these */
    bool isolines, values;        /* over the image; values: RMAP_USAGE where cells are too small */
    const double *level;          /* [n_level] of the isolines; 0: round ones */
    size_t n_level;
    const uint8_t *there; /* [n[1]][n[0]] 0: no cell, left blank; NULL: all are */
    bool uv;              /* the axes are u and v of a texture */
};

/* PNG pixels per SVG pixel that the image inside is made for. */
#define RMAP_FIGURE_SCALE 2.0

enum rmap_status rmap_figure_detector(const struct rmap_detector_image *image,
                                      const struct rmap_figure_detector *options,
                                      struct rmap_svg **svg_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
