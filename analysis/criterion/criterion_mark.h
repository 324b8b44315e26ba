/* SPDX-License-Identifier: MIT
 *
 * Which rows of a table count for a test. The loops over steps run over whole columns without
 * branches, so that compilers turn them into SIMD.
 */
#ifndef RMAP_CRITERION_MARK_H
#define RMAP_CRITERION_MARK_H

#include "analysis/criterion/criterion_tree.h"

/* The side of an object that light met in a row of /segment: bit 0 front, bit 1 back. ray: row of
 * /ray, whose segments begin at ray_row. Reads the medium where it tells; else position, normal,
 * event and ray.start: rmap_side_columns. */
unsigned rmap_side_met(const struct rmap_scene *scene, const struct rmap_portion *portion,
                       size_t row, size_t ray, size_t ray_row);

/* A stored coordinate as 0..1, or in the detector's own units: lengths about the centre, degrees
 * on an intensity grid. It never falls as `stored` rises. */
double rmap_detector_coordinate(const struct rmap_detector *detector, uint16_t stored, int axis,
                                bool as_relative);

/* flag[i] = 1 or 0 for index[i] in [0, n). */
void rmap_index_set_mark(const struct rmap_index_set *set, const int32_t *index, size_t n,
                         uint8_t *flag);

/* Mark rows that count: flag[i] = 1 or 0 for row strip->first + i. Of registrations, whatever the
 * test says of them behind `where`. */
void rmap_steps_mark(const struct rmap_criterion *criterion, const struct rmap_step_test *test,
                     const struct rmap_portion *portion, const struct rmap_strip *strip,
                     uint8_t *flag);
void rmap_registrations_mark(const struct rmap_criterion *criterion,
                             const struct rmap_registration_test *test,
                             const struct rmap_portion *portion, const struct rmap_strip *strip,
                             uint8_t *flag);

double rmap_registration_number(const struct rmap_scene *scene, const struct rmap_portion *portion,
                                size_t row, enum rmap_registration_number number);

#endif
