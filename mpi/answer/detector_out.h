/* SPDX-License-Identifier: MIT
 *
 * A detector's image as a file.
 */
#ifndef RMAP_DETECTOR_OUT_H
#define RMAP_DETECTOR_OUT_H

#include "analysis/detector/far_field.h"
#include "analysis/detector/spot.h"
#include "analysis/figure/figure_detector.h"

extern const char *const rmap_detector_suffixes[];

/* .ies or .ldt: of an image in the cells of rmap_far_field_cells alone. */
bool rmap_detector_is_lamp_file(const char *path);

/* rmap_far_field_fit, with a line on stderr where the angles do not resolve a beam. */
enum rmap_status rmap_detector_far_field(const struct rmap_detector_image *image,
                                         struct rmap_lamp_file *file,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* By the suffix. .csv: a row per cell; .h5: value, standard_error, rays, rgb, spectral cube; .npy:
 * the values alone, of a spectral image the cube; .npz: all of it; .exr: linear RGB, of an image
 * without colour the value in each; .png and .svg: the figure;
 * .ies and .ldt: lamp makers' files. */
enum rmap_status rmap_detector_write(const struct rmap_detector_image *image,
                                     const struct rmap_figure_detector *figure, const char *path,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* The table of its values (lux_table.h): .csv. */
enum rmap_status rmap_lux_table_write(const struct rmap_detector_image *image,
                                      const char *criterion, const char *path,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* Of directions, the polar diagram: .png or .svg. */
enum rmap_status rmap_polar_write(const struct rmap_detector_image *image, const char *criterion,
                                  const char *path, struct rmap_error *err) RMAP_MUST_USE;

/* A spot's curves: .csv, .png or .svg. */
enum rmap_status rmap_spot_write(const struct rmap_spot *spot, const char *detector,
                                 const char *criterion, const char *path,
                                 struct rmap_error *err) RMAP_MUST_USE;

#endif
