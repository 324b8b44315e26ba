/* SPDX-License-Identifier: MIT
 *
 * Light that a medium absorbs and gives back at another wavelength. The numbers are the same
 * everywhere, as src/compact finds them again.
 */
#include "trace/luminescence.h"

#include "base/search.h"
#include "formula/emit.h"
#include "portion/weight.h"

/* The photons of the spectrum below the wavelength absorbed are left out: of its own channel half.
 */
static int emitted_on(const struct rmap_species *its, int n_channel, int absorbed, double u)
{
    double from = 0.0;
    if (its->redshift) {
        const double before = absorbed > 0 ? its->below[absorbed - 1] : 0.0;
        from = 0.5 * (before + its->below[absorbed]);
    }
    if (!(from < its->below[n_channel - 1]))
        return absorbed;
    return (int)rmap_first_above(its->below, (size_t)n_channel,
                                 from + u * (its->below[n_channel - 1] - from));
}

bool rmap_reemit(const struct rmap_medium *medium, int n_channel, const struct rmap_draw *draw,
                 int channel, struct rmap_reemission *back)
{
    double u[4];
    rmap_rng(draw->seed, draw->ray, draw->step, RMAP_RNG_SPECIES, u);
    double left = u[0] * medium->absorption[channel];
    const struct rmap_species *its = medium->species, *end = its + medium->n_species;
    for (; its < end && left >= its->absorption[channel]; its++)
        left -= its->absorption[channel];
    if (its == end || !(u[1] < its->yield[channel]))
        return false;
    *back = (struct rmap_reemission){
        .channel = emitted_on(its, n_channel, channel, u[2]),
        .delay_ns = rmap_decay_delay(&its->lifetime, u[1] / its->yield[channel], u[3])};
    return true;
}

struct rmap_vec3 rmap_reemit_direction(const struct rmap_draw *draw)
{
    double u[4];
    rmap_rng(draw->seed, draw->ray, draw->step, RMAP_RNG_SCATTER, u);
    return rmap_about_z(2.0 * u[0], u[1]);
}

double rmap_weight_after(const struct rmap_scene *scene, int first, int now)
{
    if (scene->worth[now] == scene->worth[first])
        return 1.0;
    return rmap_weight_round(scene->worth[now] / scene->worth[first]);
}
