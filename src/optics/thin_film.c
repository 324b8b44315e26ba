/* SPDX-License-Identifier: MIT
 *
 * Stacks of thin films between two media.
 */
#include "optics/thin_film.h"

#include <complex.h>
#include <math.h>

#include "base/vec.h"

/* A medium or a layer: its index, and the cosine of the light's angle in it. */
struct place {
    double complex index, cosine;
};

/* The wave that decays, or goes on, away from where the light comes from. */
static struct place place_of(double complex index, double complex sine)
{
    const double complex s = sine / index;
    double complex cosine = csqrt(1.0 - s * s);
    if (cimag(index * cosine) < 0.0 || (cimag(index * cosine) == 0.0 && creal(cosine) < 0.0))
        cosine = -cosine;
    return (struct place){index, cosine};
}

/* Amplitudes at a boundary, and of all that lies behind it. */
struct amplitudes {
    double complex r, t;
};

static struct amplitudes boundary(const struct place *a, const struct place *b, bool in_plane)
{
    const double complex near = in_plane ? b->index * a->cosine : a->index * a->cosine;
    const double complex far = in_plane ? a->index * b->cosine : b->index * b->cosine;
    const double complex sum = near + far;
    if (sum == 0.0)
        return (struct amplitudes){-1.0, 0.0};
    return (struct amplitudes){(near - far) / sum, 2.0 * a->index * a->cosine / sum};
}

/* Power that passes, per power that arrives, per squared amplitude. */
static double flow(const struct place *first, const struct place *last, bool in_plane)
{
    const double near = creal(first->index * first->cosine);
    const double complex c = in_plane ? conj(last->cosine) : last->cosine;
    return near > 0.0 ? creal(last->index * c) / near : 0.0;
}

/* From behind: the phases of waves that decay are small, so that thick layers do no harm. */
static void polarised(const struct rmap_thin_film_layer *layer, size_t n_layer, bool backwards,
                      const struct place *first, const struct place *last, double complex sine,
                      bool in_plane, double *reflected, double *passed)
{
    struct place behind = *last;
    double complex r = 0.0, t = 1.0, phase = 1.0;
    for (size_t i = 0; i <= n_layer; i++) {
        const struct rmap_thin_film_layer *its =
            i < n_layer ? &layer[backwards ? i : n_layer - 1 - i] : NULL;
        const struct place here = its ? place_of(CMPLX(its->n, its->k), sine) : *first;
        const struct amplitudes step = boundary(&here, &behind, in_plane);
        const double complex echo = r * phase * phase;
        const double complex many = 1.0 + step.r * echo;
        t = step.t * t * phase / many;
        r = (step.r + echo) / many;
        if (its)
            phase = cexp(CMPLX(0.0, 2.0 * RMAP_PI) * here.index * here.cosine * its->thickness);
        behind = here;
    }
    *reflected = creal(r * conj(r));
    *passed = creal(t * conj(t)) * flow(first, last, in_plane);
}

struct rmap_thin_film_shares rmap_thin_film_shares(const struct rmap_thin_film_layer *layer,
                                                   size_t n_layer, bool backwards, double n1,
                                                   double n2, double k2, double cos_i)
{
    const double sine = n1 * sqrt(1.0 - cos_i * cos_i);
    struct rmap_thin_film_shares shares = {1.0, 1.0, 0.0, 0.0, k2 == 0.0 && sine >= n2 && n1 != n2};
    if (cos_i <= 0.0)
        return shares;
    const struct place first = {n1, cos_i}, last = place_of(CMPLX(n2, k2), sine);
    polarised(layer, n_layer, backwards, &first, &last, sine, false, &shares.rs, &shares.ts);
    polarised(layer, n_layer, backwards, &first, &last, sine, true, &shares.rp, &shares.tp);
    if (shares.total)
        shares.ts = shares.tp = 0.0;
    return shares;
}
