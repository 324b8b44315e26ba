/* SPDX-License-Identifier: MIT
 *
 * The nearest of Planck's radiators in the diagram of 1960, the distance having the sign of what
 * lies above the locus (Ohno 2014, doi:10.1080/15502724.2014.839020); between the steps of its
 * table the locus is a parabola, so that the nearest point is found without his two corrections.
 */
#include "optics/chromaticity.h"

#include <math.h>

#include "optics/spectrum.h"

static const double FIRST_MIRED = 10.0, STEP_MIRED = 2.0, DUV_MOST = 0.05;

void rmap_uv1960(const double xyz[3], double uv[2])
{
    const double sum = xyz[0] + 15.0 * xyz[1] + 3.0 * xyz[2];
    uv[0] = 4.0 * xyz[0] / sum;
    uv[1] = 6.0 * xyz[1] / sum;
}

void rmap_planck_locus_fill(struct rmap_planck_locus *locus)
{
    for (int i = 0; i < RMAP_PLANCK_N; i++) {
        double xyz[3] = {0.0, 0.0, 0.0};
        for (int nm = 360; nm <= 830; nm += 5) {
            double bar[3];
            const double power = rmap_blackbody(1e6 / (FIRST_MIRED + STEP_MIRED * i), (double)nm);
            rmap_cie1931((double)nm, bar);
            for (int k = 0; k < 3; k++)
                xyz[k] += power * bar[k];
        }
        rmap_uv1960(xyz, locus->uv[i]);
    }
}

static double distance(const double a[2], const double b[2])
{
    return hypot(a[0] - b[0], a[1] - b[1]);
}

/* Beside step i: from the nearest place on the parabola to uv, and where that is, in steps. */
static double nearest(const struct rmap_planck_locus *locus, int i, const double uv[2],
                      double away[2])
{
    const double(*p)[2] = &locus->uv[i];
    double t = 0.0;
    for (int round = 0; round < 5; round++) {
        double slope = 0.0, bend = 0.0;
        for (int k = 0; k < 2; k++) {
            const double first = 0.5 * (p[1][k] - p[-1][k]),
                         second = p[1][k] - 2.0 * p[0][k] + p[-1][k];
            const double along = first + t * second;
            away[k] = uv[k] - (p[0][k] + t * (first + 0.5 * t * second));
            slope -= away[k] * along;
            bend += along * along - away[k] * second;
        }
        t -= slope / bend;
    }
    return t;
}

static void find_temperature(const struct rmap_planck_locus *locus, const double uv[2],
                             struct rmap_chromaticity *of)
{
    int best = 0;
    double away[2], least = distance(uv, locus->uv[0]);
    for (int i = 1; i < RMAP_PLANCK_N; i++) {
        const double its = distance(uv, locus->uv[i]);
        if (!(its < least))
            continue;
        least = its;
        best = i;
    }
    if (best == 0 || best == RMAP_PLANCK_N - 1 || least > DUV_MOST)
        return;
    const double t = nearest(locus, best, uv, away);
    of->kelvin = 1e6 / (FIRST_MIRED + STEP_MIRED * (best + t));
    of->duv = copysign(hypot(away[0], away[1]), away[1]);
}

void rmap_chromaticity_of(const struct rmap_planck_locus *locus, const double xyz[3],
                          struct rmap_chromaticity *of)
{
    const double sum = xyz[0] + xyz[1] + xyz[2];
    const double none = (double)NAN;
    *of = (struct rmap_chromaticity){none, none, none, none, none, none};
    if (!(sum > 0.0))
        return;
    double uv[2];
    rmap_uv1960(xyz, uv);
    of->x = xyz[0] / sum;
    of->y = xyz[1] / sum;
    of->u = uv[0];
    of->v = 1.5 * uv[1];
    find_temperature(locus, uv, of);
}
