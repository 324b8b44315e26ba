/* SPDX-License-Identifier: MIT
 *
 * Improved noise (Perlin 2002, doi:10.1145/566654.566636) in octaves: turbulence, striae.
 */
#ifndef RMAP_FIELD_NOISE_H
#define RMAP_FIELD_NOISE_H

#include <stdint.h>

#include "base/status.h"
#include "gradient/field.h"

#define RMAP_NOISE_OCTAVE_MAX 16

/* value = mean + amplitude * sum over octaves o of persistence^o noise_o(p lacunarity^o / length),
 * |noise| <= 1.04, 0 at lattice points; each octave has a permutation of its own, drawn by Philox
 * from the seed. Period: 256 cells. */
struct rmap_noise {
    double mean,
        amplitude; /* the wavelength-dependent ones: one structure per channel, else equal */
    double length; /* edge of a cell of the first octave, > 0 */
    double persistence, lacunarity; /* usual: 0.5, 2 */
    int n_octave;                   /* 1 to RMAP_NOISE_OCTAVE_MAX */
    uint64_t seed;
};

/* parameter: [n_channel]; mean and amplitude may differ. RMAP_INPUT names what is wrong. */
enum rmap_status rmap_field_noise(struct rmap_field **field_ret, int n_channel,
                                  const struct rmap_noise *parameter,
                                  struct rmap_error *err) RMAP_MUST_USE;

#endif
