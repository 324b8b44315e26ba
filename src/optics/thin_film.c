/* SPDX-License-Identifier: MIT
 *
 * Stacks of thin films between two media.
 */
#include "optics/thin_film.h"

#include <complex.h>
#include <math.h>

#include "base/vec.h"

/* A medium or a layer: its index, the cosine of the light's angle in it, and their product. */
struct place {
    double complex index, cosine, along;
};

/* The wave that decays, or goes on, away from where the light comes from. */
static struct place place_of(double n, double k, double sine)
{
    struct place place = {.index = CMPLX(n, k)};
    const double s = sine / n, left = 1.0 - s * s;
    if (k == 0.0) {
        place.cosine = left >= 0.0 ? CMPLX(sqrt(left), 0.0) : CMPLX(0.0, sqrt(-left));
        place.along = n * place.cosine;
        return place;
    }
    const double complex ratio = sine / place.index;
    place.cosine = csqrt(1.0 - ratio * ratio);
    place.along = place.index * place.cosine;
    if (cimag(place.along) < 0.0) {
        place.cosine = -place.cosine;
        place.along = -place.along;
    }
    return place;
}

/* Amplitudes of all that lies behind a boundary, of one polarisation. */
struct amplitudes {
    double complex r, t;
};

static inline double power(double complex amplitude)
{
    return creal(amplitude) * creal(amplitude) + cimag(amplitude) * cimag(amplitude);
}

/* Light goes through a boundary, whose own amplitudes are (near - far) / (near + far) and 2
 * arriving / (near + far), and across what lies behind it, whose phase is `phase`. */
static inline void go_on(double complex near, double complex far, double complex arriving,
                         double complex phase, struct amplitudes *all)
{
    const double complex echo = all->r * phase * phase, sum = near + far, less = near - far;
    const double complex under = sum + less * echo;
    if (under == 0.0) /* along a boundary of equals: there is none */
        return;
    const double complex inverse = conj(under) / power(under);
    all->t = 2.0 * arriving * all->t * phase * inverse;
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
    const struct place first = {CMPLX(n1, 0.0), CMPLX(cos_i, 0.0), CMPLX(n1 * cos_i, 0.0)};
    const struct place last = place_of(n2, k2, sine);
    struct amplitudes across = {0.0, 1.0}, within = {0.0, 1.0};
    struct place behind = last;
    double complex phase = 1.0;
    for (size_t i = 0; i <= n_layer; i++) {
        const struct rmap_thin_film_layer *its =
            i < n_layer ? &layer[backwards ? i : n_layer - 1 - i] : NULL;
        const struct place here = its ? place_of(its->n, its->k, sine) : first;
        go_on(here.along, behind.along, here.along, phase, &across);
        go_on(behind.index * here.cosine, here.index * behind.cosine, here.along, phase, &within);
        if (its) {
            const double turns = 2.0 * RMAP_PI * its->thickness;
            const double decay = exp(-turns * cimag(here.along)), at = turns * creal(here.along);
            phase = CMPLX(decay * cos(at), decay * sin(at));
        }
        behind = here;
    }
    const double arriving = n1 * cos_i;
    shares.rs = power(across.r);
    shares.rp = power(within.r);
    if (shares.total)
        return shares;
    shares.ts = power(across.t) * creal(last.along) / arriving;
    shares.tp = power(within.t) * creal(last.index * conj(last.cosine)) / arriving;
    return shares;
}
