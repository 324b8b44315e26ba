/* SPDX-License-Identifier: MIT
 *
 * Interpolating cubic splines, C2 (de Boor 1978, A Practical Guide to Splines, ch. IV), on by their
 * tangents beyond the points.
 */
#ifndef RMAP_SPLINE_H
#define RMAP_SPLINE_H

#include "base/status.h"

struct rmap_spline {
    int n_point;
    double *x, *y, *second; /* [n_point]; one block, owned, at x */
};

enum rmap_spline_start {
    RMAP_SPLINE_NATURAL, /* second derivative 0 at the first point */
    RMAP_SPLINE_EVEN     /* first derivative 0 there: even about it */
};

/* x: [n_point], increasing, n_point >= 2; copied. The last point is natural. RMAP_INPUT for points
 * that are too few, not finite or not increasing, with `what` before the text; RMAP_SYSTEM. */
enum rmap_status rmap_spline_init(struct rmap_spline *spline, const char *what, int n_point,
                                  const double *x, const double *y, enum rmap_spline_start start,
                                  struct rmap_error *err) RMAP_MUST_USE;
void rmap_spline_fini(struct rmap_spline *spline); /* of a zeroed one: fine */

/* f: value, first and second derivative at x. */
void rmap_spline_at(const struct rmap_spline *spline, double x, double f[3]);

#endif
