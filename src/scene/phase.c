/* SPDX-License-Identifier: MIT
 *
 * Phase functions of scattering media. What light is turned by is drawn from these numbers: of +,
 * -, x, / and square roots alone, so that it is the same everywhere.
 */
#include "scene/phase.h"

#include <math.h>

#include "base/alloc.h"
#include "formula/azimuth.h"

void rmap_phase_fini(struct rmap_phase *phase)
{
    for (size_t i = 0; phase->profile && i < phase->n_profile; i++)
        rmap_profile_fini(&phase->profile[i]);
    rmap_free(phase->profile);
    rmap_free(phase->suspended);
    *phase = (struct rmap_phase){.kind = RMAP_PHASE_HENYEY};
}

/* The knot that follows; equal ones would make nothing of what lies between them. */
static void add_knot(struct rmap_profile *profile, double radians, double intensity)
{
    const double at = radians >= RMAP_PI ? 2.0 : rmap_one_minus_cos(radians / (2.0 * RMAP_PI));
    if (profile->n == 0 || at > profile->knot[profile->n - 1].one_minus_cos)
        profile->knot[profile->n++] =
            (struct rmap_profile_knot){.one_minus_cos = at, .intensity = intensity};
}

static enum rmap_status no_memory(struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a phase function");
}

enum rmap_status rmap_phase_make_room(struct rmap_phase *phase, size_t n, struct rmap_error *err)
{
    phase->profile = rmap_alloc(n, sizeof *phase->profile);
    phase->suspended = rmap_alloc(n, sizeof *phase->suspended);
    return phase->profile && phase->suspended ? RMAP_OK : no_memory(err);
}

enum rmap_status rmap_phase_add_table(const double *angle_deg, const double *value, size_t n,
                                      struct rmap_phase *phase, struct rmap_error *err)
{
    const double step_deg = 0.5;
    size_t n_knot = 1;
    struct rmap_profile *profile = &phase->profile[phase->n_profile++];
    for (size_t i = 1; i < n; i++)
        n_knot += 1 + (size_t)((angle_deg[i] - angle_deg[i - 1]) / step_deg);
    profile->knot = rmap_alloc(n_knot, sizeof *profile->knot);
    if (!profile->knot)
        return no_memory(err);
    add_knot(profile, angle_deg[0] * (RMAP_PI / 180.0), value[0]);
    for (size_t i = 1; i < n; i++) {
        const double width = angle_deg[i] - angle_deg[i - 1];
        const size_t n_step = 1 + (size_t)(width / step_deg);
        for (size_t s = 1; s <= n_step; s++) {
            const double part = (double)s / (double)n_step;
            add_knot(profile, (angle_deg[i - 1] + part * width) * (RMAP_PI / 180.0),
                     value[i - 1] + part * (value[i] - value[i - 1]));
        }
    }
    return profile->n > 1 && rmap_profile_sum(profile) > 0.0
               ? RMAP_OK
               : rmap_error_set(err, RMAP_INPUT,
                                "a phase function that scatters light is wanted: "
                                "values above 0 somewhere");
}

/* Angles of a table for spheres of up to this size parameter: some twenty within the forward peak,
 * ten in each ripple behind it, as far as there is room. */
enum { ANGLES_MAX = 4096 };

static void set_angles(double x, bool alike, struct rmap_profile *profile)
{
    const double widest = alike ? RMAP_PI / (10.0 * x) : HUGE_VAL, coarse = RMAP_PI / 720.0,
                 fine = RMAP_PI / 3600.0;
    const double most = widest > coarse ? coarse : widest > fine ? widest : fine;
    double step = 0.05 / x, at = 0.0;
    for (step = step < most ? step : most; at < RMAP_PI && profile->n + 1 < ANGLES_MAX;) {
        add_knot(profile, at, 0.0);
        at += step;
        step = 1.05 * step < most ? 1.05 * step : most;
    }
    add_knot(profile, RMAP_PI, 0.0);
}

enum rmap_status rmap_phase_add_mie(const struct rmap_suspension *spheres, double wavelength,
                                    double n, double k, struct rmap_phase *phase,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_profile *profile = &phase->profile[phase->n_profile++];
    double *cosine = rmap_alloc(ANGLES_MAX, sizeof *cosine),
           *intensity = rmap_alloc(ANGLES_MAX, sizeof *intensity);
    profile->knot = rmap_alloc(ANGLES_MAX, sizeof *profile->knot);
    if (!cosine || !intensity || !profile->knot)
        RMAP_TRY(no_memory(err));
    set_angles(RMAP_PI * rmap_suspension_largest(spheres) / wavelength, spheres->sigma <= 1.0,
               profile);
    for (size_t i = 0; i < profile->n; i++)
        cosine[i] = 1.0 - profile->knot[i].one_minus_cos;
    RMAP_TRY(rmap_suspension_scatter(spheres, wavelength, n, k, profile->n, cosine, intensity,
                                     &phase->suspended[phase->n_profile - 1], err));
    for (size_t i = 0; i < profile->n; i++)
        profile->knot[i].intensity = intensity[i];
    (void)rmap_profile_sum(profile);
out:
    rmap_free(cosine);
    rmap_free(intensity);
    return st;
}

/* Between knots 2 pi (I0 + s t) (1 - w0 - t), t from 0 to the width. */
double rmap_phase_mean_cosine(const struct rmap_profile *profile)
{
    double sum = 0.0;
    for (size_t k = 1; k < profile->n; k++) {
        const struct rmap_profile_knot *knot = &profile->knot[k - 1];
        const double width = knot[1].one_minus_cos - knot[0].one_minus_cos;
        sum += 2.0 * RMAP_PI * width *
               (0.5 * (knot[0].intensity + knot[1].intensity) * (1.0 - knot[0].one_minus_cos) -
                width * (knot[0].intensity / 6.0 + knot[1].intensity / 3.0));
    }
    return sum;
}
