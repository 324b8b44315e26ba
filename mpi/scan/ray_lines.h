/* SPDX-License-Identifier: MIT
 *
 * A ray as lines of text: one line of its path in letters, or CSV rows.
 */
#ifndef RMAP_RAY_LINES_H
#define RMAP_RAY_LINES_H

#include <stdio.h>

#include "analysis/report/ray_report.h"

/* One row per segment: what the ray is, where the segment began and ended, what happened there.
 * Events of one step are joined by '+', registrations on the segment by ';'; angle of incidence in
 * degrees and specular reflectance, as in the report. Rows of a scene with gradient media end with
 * `curve`: the points of a curved segment between its ends, "x y z;x y z". */

/* The first line, of the columns' names. */
const char *rmap_ray_csv_header(const struct rmap_scene *scene);

enum rmap_status rmap_ray_csv_write(const struct rmap_ray_report *report, FILE *out,
                                    struct rmap_error *err);

/* "17  T@lens.1 R@lens.3 V@sensor A@sensor": the letters of the criterion language's path. */
enum rmap_status rmap_ray_path_write(const struct rmap_ray_report *report, FILE *out,
                                     struct rmap_error *err);

#endif
