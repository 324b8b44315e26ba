/* SPDX-License-Identifier: MIT
 *
 * What an intensity grid registered, as a lamp maker's file has it: candelas at angles, linear
 * between them.
 */
#ifndef RMAP_FAR_FIELD_H
#define RMAP_FAR_FIELD_H

#include "analysis/detector/detector_image.h"
#include "io/lamp/lamp_file.h"

/* n steps of gamma and planes C: the cells to ask for, [0] of theta and [1] of phi, are half of
 * them, so that each angle of the file lies in the middle of two. */
void rmap_far_field_cells(const uint32_t n[2], uint32_t cells[2]);

/* Of an image in such cells and in cd: the candelas that, linear between the angles (n + 1 of
 * gamma, planes C clockwise about the axis), send the same flux into each pair of cells. Where that
 * asked for less than 0 the flux goes to the angles beside; in all it stays. moved_ret: how much of
 * it, in parts of all. RMAP_SYSTEM; *file is the caller's to finish in any case. */
enum rmap_status rmap_far_field_fit(const struct rmap_detector_image *image,
                                    struct rmap_lamp_file *file, double *moved_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;

#endif
