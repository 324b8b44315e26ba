/* SPDX-License-Identifier: MIT
 *
 * Cosine and sine of a whole turn's fraction. Own polynomials, as the C library picks its sin and
 * cos by the processor, and a ray must come out the same on every node of a run.
 */
#ifndef RMAP_AZIMUTH_H
#define RMAP_AZIMUTH_H

#include "base/vec.h"

/* turns in [0, 1]. Taylor series about the nearest quarter turn, |x| <= pi / 4: the first terms
 * left out are x^17 / 17! < 5e-17 and x^18 / 18! < 3e-18. */
static inline void rmap_azimuth(double turns, double *cosine, double *sine)
{
    int quarter = (int)(4.0 * turns + 0.5);
    double x = 2.0 * RMAP_PI * (turns - 0.25 * (double)quarter), y = x * x, y2 = y * y,
           y4 = y2 * y2;
    double s = ((1.0 - y * (1.0 / 6.0)) + y2 * (1.0 / 120.0 - y * (1.0 / 5040.0))) +
               y4 * ((1.0 / 362880.0 - y * (1.0 / 39916800.0)) +
                     y2 * (1.0 / 6227020800.0 - y * (1.0 / 1307674368000.0)));
    double c = ((1.0 - y * (1.0 / 2.0)) + y2 * (1.0 / 24.0 - y * (1.0 / 720.0))) +
               y4 * ((1.0 / 40320.0 - y * (1.0 / 3628800.0)) +
                     y2 * ((1.0 / 479001600.0 - y * (1.0 / 87178291200.0)) +
                           y2 * (1.0 / 20922789888000.0)));
    s *= x;
    double along = quarter & 1 ? -s : c, across = quarter & 1 ? c : s;
    *cosine = quarter & 2 ? -along : along;
    *sine = quarter & 2 ? -across : across;
}

/* 1 - cos of an angle, which keeps its digits where that is small. turns in [0, 2]. */
static inline double rmap_one_minus_cos(double turns)
{
    double cosine, sine;
    rmap_azimuth(0.5 * turns, &cosine, &sine);
    return 2.0 * sine * sine;
}

#endif
