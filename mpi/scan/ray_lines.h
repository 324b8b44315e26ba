/* SPDX-License-Identifier: MIT
 *
 * A ray as lines of text: one line of its path in letters, or CSV rows.
 */
#ifndef RMAP_RAY_LINES_H
#define RMAP_RAY_LINES_H

#include <stdio.h>

#include "analysis/report/ray_report.h"

/* One row per segment: what the ray is, where the segment began and ended, what happened there.
 * Events of one step are joined by '+', registrations on the segment by ';'. Rows of a scene with
 * gradient media end with `curve`: the points of a curved segment between its ends, "x y z;x y z".
 */
#define RMAP_RAY_CSV_HEADER                                                                        \
    "ray,source,stop,flux,wavelength,step,object,face,primitive,events,medium,x0,y0,z0,x,y,z,nx,"  \
    "ny,nz,length,detectors"

#define RMAP_RAY_CSV_HEADER_CURVED RMAP_RAY_CSV_HEADER ",curve"

enum rmap_status rmap_ray_csv_write(const struct rmap_ray_report *report, FILE *out,
                                    struct rmap_error *err);

/* "17  T@lens.1 R@lens.3 V@sensor A@sensor": the letters of the criterion language's path. */
enum rmap_status rmap_ray_path_write(const struct rmap_ray_report *report, FILE *out,
                                     struct rmap_error *err);

#endif
