/* SPDX-License-Identifier: MIT
 *
 * Absorption and scattering inside a medium: a free path drawn per segment, and what happens at its
 * end (analog Monte Carlo).
 */
#include "trace/turbid.h"

#include <math.h>

#include "base/rng.h"
#include "formula/azimuth.h"
#include "portion/event.h"

void rmap_free_path_draw(const struct rmap_medium *medium, const struct rmap_draw *draw,
                         const struct rmap_colour *colour, struct rmap_free_path *path)
{
    rmap_rng(draw->seed, draw->ray, draw->step, RMAP_RNG_MEDIUM, path->u);
    int channel = rmap_colour_pick(colour, NULL, path->u[0]);
    double mu = medium->absorption[channel] + medium->scattering[channel];
    path->length = -log(path->u[1]) / mu;
}

/* Density of the path's length per channel where something happened at its end, else the share
 * that gets so far. */
static void weigh_way(const struct rmap_medium *medium, double length, bool ended,
                      struct rmap_colour *colour)
{
    double p[RMAP_CHANNEL_MAX], mu = -1.0;
    for (int i = colour->begin; i < colour->end; i++) {
        double mu_i = medium->absorption[i] + medium->scattering[i];
        if (mu_i == mu)
            p[i] = p[i - 1]; /* exp is dear, and many media are grey */
        else
            p[i] = exp(-mu_i * length) * (ended ? mu_i : 1.0);
        mu = mu_i;
    }
    rmap_colour_weigh(colour, p);
}

/* Absorbed or scattered? By each channel's share of absorption, turned over where scattered. */
static uint32_t choose(const struct rmap_medium *medium, double u, struct rmap_colour *colour)
{
    double absorbed[RMAP_CHANNEL_MAX];
    if (!medium->scattering_at_all)
        return RMAP_EVENT_ABSORB;
    if (!medium->absorbing)
        return RMAP_EVENT_SCATTER_VOLUME;
    for (int i = colour->begin; i < colour->end; i++) {
        double mu = medium->absorption[i] + medium->scattering[i];
        absorbed[i] = mu > 0.0 ? medium->absorption[i] / mu : 0.0;
    }
    bool is_absorbed = u < rmap_colour_sum(colour, absorbed);
    for (int i = colour->begin; i < colour->end && !is_absorbed; i++)
        absorbed[i] = 1.0 - absorbed[i];
    if (!rmap_colour_single(colour))
        rmap_colour_weigh(colour, absorbed);
    return is_absorbed ? RMAP_EVENT_ABSORB : RMAP_EVENT_SCATTER_VOLUME;
}

uint32_t rmap_free_path_end(const struct rmap_medium *medium, const struct rmap_free_path *path,
                            double length, bool ended, struct rmap_colour *colour)
{
    if (!rmap_colour_single(colour))
        weigh_way(medium, length, ended, colour);
    return ended ? choose(medium, path->u[2], colour) : 0;
}

/* cos theta = (1 + g^2 - ((1 - g^2) / (1 + g s))^2) / (2 g) with s uniform in (-1, 1), as a
 * fraction in which nothing cancels at small g. */
static double henyey_cosine(double g, double u)
{
    const double s = 2.0 * u - 1.0, square = (1.0 + g * s) * (1.0 + g * s);
    const double cosine =
        (2.0 * s * (1.0 + g * g) + g * (3.0 + s * s - g * g * (1.0 - s * s))) / (2.0 * square);
    return fmax(-1.0, fmin(1.0, cosine));
}

/* 3/4 of 1/2 and 1/4 of 3 cos^2 / 2; the largest of three uniform numbers has the density 3 x^2. */
static double rayleigh_cosine(const double u[4])
{
    if (u[0] < 0.75)
        return 2.0 * u[2] - 1.0;
    const double rest = 8.0 * (u[0] - 0.75), third = rest < 1.0 ? rest : rest - 1.0,
                 most = fmax(third, fmax(u[2], u[3]));
    return rest < 1.0 ? -most : most;
}

struct rmap_vec3 rmap_scatter(const struct rmap_medium *medium, const struct rmap_draw *draw,
                              struct rmap_colour *colour, struct rmap_vec3 direction)
{
    const struct rmap_phase *phase = &medium->phase;
    double u[4], along, across, cosine, sine;
    struct rmap_vec3 x, y;
    rmap_rng(draw->seed, draw->ray, draw->step, RMAP_RNG_SCATTER, u);
    if (phase->n_profile > 0) {
        if (phase->n_profile > 1 && !rmap_colour_single(colour))
            rmap_colour_collapse(colour, rmap_colour_pick(colour, NULL, u[2]));
        const double turned = rmap_profile_draw(rmap_phase_profile(phase, colour->begin), u[0]);
        cosine = 1.0 - turned;
        sine = sqrt(turned * (2.0 - turned));
    } else {
        cosine = phase->kind == RMAP_PHASE_RAYLEIGH ? rayleigh_cosine(u)
                                                    : henyey_cosine(medium->scattering_g, u[0]);
        sine = sqrt((1.0 - cosine) * (1.0 + cosine));
    }
    rmap_basis(direction, &x, &y);
    rmap_azimuth(u[1], &along, &across);
    struct rmap_vec3 aside = rmap_axpy(sine * along, x, rmap_scale(y, sine * across));
    return rmap_normalize(rmap_axpy(cosine, direction, aside));
}

double rmap_phase_density(const struct rmap_medium *medium, int channel, double cosine)
{
    const double g = medium->scattering_g, square = 1.0 + g * g - 2.0 * g * cosine;
    switch (medium->phase.kind) {
    case RMAP_PHASE_RAYLEIGH:
        return 3.0 / (16.0 * RMAP_PI) * (1.0 + cosine * cosine);
    case RMAP_PHASE_TABLE:
    case RMAP_PHASE_MIE:
        return rmap_profile_intensity(rmap_phase_profile(&medium->phase, channel), 1.0 - cosine);
    case RMAP_PHASE_HENYEY:
        break;
    }
    return (1.0 - g * g) / (4.0 * RMAP_PI * square * sqrt(square));
}
