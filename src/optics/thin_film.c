/* SPDX-License-Identifier: MIT
 *
 * Stacks of thin films between two media.
 */
#include "optics/thin_film.h"

#include <math.h>

#include "base/portable.h"
#include "formula/azimuth.h"
#include "optics/complex_number.h"

/* A medium or a layer: the square of its index, and its index times the cosine of the light's angle
 * in it, of the wave that decays, or goes on, away from where the light comes from. */
struct place {
    double complex square, along;
};

/* `sine`: index times sine, which all places have. */
static struct place place_of(double n, double k, double sine)
{
    const double re = (n - k) * (n + k), im = 2.0 * n * k, left = re - sine * sine;
    const double size = k == 0.0 ? fabs(left) : sqrt(left * left + im * im);
    const double large = sqrt(0.5 * (size + fabs(left))),
                 small = large > 0.0 ? 0.5 * im / large : 0.0;
    return (struct place){.square = CMPLX(re, im),
                          .along = left < 0.0 ? CMPLX(small, large) : CMPLX(large, small)};
}

/* Amplitudes of all that lies behind a boundary, of one polarisation: of the electric field across
 * the plane of incidence, of the magnetic one in it. */
struct amplitudes {
    double complex r, t;
};

static inline double power(double complex amplitude)
{
    return creal(amplitude) * creal(amplitude) + cimag(amplitude) * cimag(amplitude);
}

/* Light goes through a boundary, whose own amplitudes are (near - far) / (near + far) and
 * 2 near / (near + far), and across what lies behind it, whose phase is `phase`. */
static inline void go_on(double complex near, double complex far, double complex phase,
                         struct amplitudes *all)
{
    const double complex echo = all->r * phase * phase, sum = near + far, less = near - far;
    const double complex under = sum + less * echo;
    if (under == 0.0) /* along a boundary of equals: there is none */
        return;
    const double complex inverse = conj(under) / power(under);
    all->t = 2.0 * near * all->t * phase * inverse;
    all->r = (less + sum * echo) * inverse;
}

/* From behind: the phases of waves that decay are small, so that thick layers do no harm. */
struct rmap_thin_film_shares rmap_thin_film_shares(const struct rmap_thin_film_layer *layer,
                                                   size_t n_layer, bool backwards, double n1,
                                                   double n2, double k2, double cos_i)
{
    const double sine = n1 * sqrt(1.0 - cos_i * cos_i);
    struct rmap_thin_film_shares shares = {1.0, 1.0, 0.0, 0.0, k2 == 0.0 && sine >= n2 && n1 != n2};
    if (cos_i <= 0.0)
        return shares;
    const struct place first = {CMPLX(n1 * n1, 0.0), CMPLX(n1 * cos_i, 0.0)};
    const struct place last = place_of(n2, k2, sine);
    struct amplitudes across = {0.0, 1.0}, within = {0.0, 1.0};
    struct place behind = last;
    double complex phase = 1.0;
    for (size_t i = 0; i <= n_layer; i++) {
        const struct rmap_thin_film_layer *its =
            i < n_layer ? &layer[backwards ? i : n_layer - 1 - i] : NULL;
        const struct place here = its ? place_of(its->n, its->k, sine) : first;
        go_on(here.along, behind.along, phase, &across);
        go_on(behind.square * here.along, here.square * behind.along, phase, &within);
        if (its) {
            const double turns = its->thickness * creal(here.along),
                         lost = its->thickness * cimag(here.along), part = turns - floor(turns);
            double x, y, decay = lost > 0.0 ? rmap_portable_exp(-2.0 * RMAP_PI * lost) : 1.0;
            rmap_azimuth(part < 1.0 ? part : 0.0, &x, &y); /* none of a damaged map's */
            phase = CMPLX(decay * x, decay * y);
        }
        behind = here;
    }
    shares.rs = power(across.r);
    shares.rp = power(within.r);
    if (shares.total)
        return shares;
    shares.ts = power(across.t) * creal(last.along) / (n1 * cos_i);
    shares.tp =
        power(within.t) * creal(last.along * conj(last.square)) * n1 / (power(last.square) * cos_i);
    return shares;
}
