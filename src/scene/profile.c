/* SPDX-License-Identifier: MIT
 *
 * Intensity about an axis as a table of the angle to it.
 */
#include "scene/profile.h"

#include <math.h>

#include "base/alloc.h"
#include "base/vec.h"

static const double step_deg = 0.5;

/* By the trapezoidal rule, which is exact for the knots. */
double rmap_profile_sum(struct rmap_profile *profile)
{
    struct rmap_profile_knot *knot = profile->knot;
    double flux = 0.0;
    for (size_t k = 1; k < profile->n; k++) {
        flux += RMAP_PI * (knot[k].intensity + knot[k - 1].intensity) *
                (knot[k].one_minus_cos - knot[k - 1].one_minus_cos);
        knot[k].below = flux;
    }
    if (!(flux > 0.0) || !isfinite(flux))
        return 0.0;
    for (size_t k = 0; k < profile->n; k++) {
        knot[k].intensity /= flux;
        knot[k].below /= flux;
    }
    return flux;
}

enum rmap_status rmap_profile_init(const double *angle_deg, const double *value, size_t n,
                                   struct rmap_profile *profile, struct rmap_error *err)
{
    double most = 0.0;
    size_t n_knot = 1;
    *profile = (struct rmap_profile){0};
    for (size_t i = 0; i < n; i++)
        most = fmax(most, value[i]);
    if (n < 2 || !(most > 0.0))
        return rmap_error_set(err, RMAP_INPUT, "an intensity that is above 0 somewhere is wanted");
    for (size_t i = 1; i < n; i++)
        n_knot += (size_t)ceil((angle_deg[i] - angle_deg[i - 1]) / step_deg);
    struct rmap_profile_knot *knot = profile->knot = rmap_alloc(n_knot, sizeof *knot);
    if (!knot)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a table of intensity");
    for (size_t i = 0; i < n; i++) {
        const double width = i ? angle_deg[i] - angle_deg[i - 1] : 0.0;
        const size_t n_step = i ? (size_t)ceil(width / step_deg) : 1;
        for (size_t s = 1; s <= n_step; s++) {
            const double part = (double)(n_step - s) / (double)n_step;
            const double half_sine = sin((angle_deg[i] - part * width) * RMAP_PI / 360.0);
            const double before = i ? value[i - 1] : value[i];
            knot[profile->n++] = (struct rmap_profile_knot){
                .one_minus_cos = 2.0 * half_sine * half_sine,
                .intensity = (value[i] + part * (before - value[i])) / most};
        }
    }
    return rmap_profile_sum(profile) > 0.0
               ? RMAP_OK
               : rmap_error_set(err, RMAP_INPUT, "the table of intensity has no light");
}

void rmap_profile_fini(struct rmap_profile *profile)
{
    rmap_free(profile->knot);
    *profile = (struct rmap_profile){0};
}

/* The first of the two knots between which an angle lies, told by 1 - cos of it, or else by the
 * share of the flux below it. */
static size_t find_knot(const struct rmap_profile *profile, bool by_share, double value)
{
    size_t low = 0, high = profile->n - 1;
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        const struct rmap_profile_knot *knot = &profile->knot[middle];
        if ((by_share ? knot->below : knot->one_minus_cos) > value)
            high = middle;
        else
            low = middle;
    }
    return low;
}

size_t rmap_profile_find(const struct rmap_profile *profile, double one_minus_cos)
{
    return find_knot(profile, false, one_minus_cos);
}

double rmap_profile_draw(const struct rmap_profile *profile, double u)
{
    const struct rmap_profile_knot *knot = profile->knot;
    const size_t low = find_knot(profile, true, u), high = low + 1;
    /* from the knot on the flux is 2 pi (intensity t + slope t^2 / 2) */
    const double width = knot[high].one_minus_cos - knot[low].one_minus_cos;
    const double slope = (knot[high].intensity - knot[low].intensity) / width;
    const double rest = (u - knot[low].below) / (2.0 * RMAP_PI);
    const double square = knot[low].intensity * knot[low].intensity + 2.0 * slope * rest;
    const double divisor = knot[low].intensity + sqrt(square > 0.0 ? square : 0.0);
    const double t = divisor > 0.0 ? 2.0 * rest / divisor : 0.0;
    return knot[low].one_minus_cos + (t < width ? t : width);
}

double rmap_profile_intensity(const struct rmap_profile *profile, double one_minus_cos)
{
    const struct rmap_profile_knot *knot = profile->knot;
    if (one_minus_cos < knot[0].one_minus_cos || one_minus_cos > knot[profile->n - 1].one_minus_cos)
        return 0.0;
    knot += rmap_profile_find(profile, one_minus_cos);
    const double share =
        (one_minus_cos - knot[0].one_minus_cos) / (knot[1].one_minus_cos - knot[0].one_minus_cos);
    return knot[0].intensity + share * (knot[1].intensity - knot[0].intensity);
}
