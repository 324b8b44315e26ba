/* SPDX-License-Identifier: MIT
 *
 * Whole numbers of photons by chance.
 */
#include "optics/photon_number.h"

#include "base/portable.h"
#include "formula/azimuth.h"

/* Of a mean that a uniform number of 32 bits reaches the tails of. */
#define PART_MEAN 16.0
/* And beyond which both distributions are as good as one. */
#define POISSON_MAX 1e9

static uint64_t invert(double mean, double u)
{
    double term = rmap_portable_exp(-mean), below = term;
    uint64_t k = 0;
    while (below < u && k < 128) {
        k++;
        term *= mean / (double)k;
        below += term;
    }
    return k;
}

/* The sum of independent numbers of smaller means. */
uint64_t rmap_poisson(double mean, uint64_t seed, uint64_t which, enum rmap_rng_slot slot,
                      uint32_t *step)
{
    const uint64_t n_part = (uint64_t)(mean / PART_MEAN) + 1;
    uint64_t sum = 0;
    double u[4];
    for (uint64_t part = 0; part < n_part; part++) {
        if (part % 4 == 0)
            rmap_rng(seed, which, (*step)++, slot, u);
        sum += invert(mean / (double)n_part, u[part % 4]);
    }
    return sum;
}

/* Rounded up or down by chance, so that the mean is kept (Box & Muller 1958,
 * doi:10.1214/aoms/1177706645). */
static uint64_t normal(double mean, double resolution, uint64_t seed, uint64_t which)
{
    double u[4], cosine, sine;
    rmap_rng(seed, which, 0, RMAP_RNG_PHOTON_NUMBER, u);
    rmap_azimuth(u[1], &cosine, &sine);
    const double number =
        mean + resolution * sqrt(mean) * cosine * sqrt(-2.0 * rmap_portable_log(u[0]));
    return number + u[2] > 0.0 ? (uint64_t)(number + u[2]) : 0;
}

uint64_t rmap_photon_number(double mean, double resolution, uint64_t seed, uint64_t which)
{
    uint32_t step = 0;
    if (!(mean > 0.0))
        return 0;
    return (resolution == 1.0 && mean <= POISSON_MAX) || mean <= 10.0
               ? rmap_poisson(mean, seed, which, RMAP_RNG_PHOTON_NUMBER, &step)
               : normal(mean, resolution, seed, which);
}
