/* SPDX-License-Identifier: MIT
 *
 * Whole numbers of photons by chance.
 */
#ifndef RMAP_PHOTON_NUMBER_H
#define RMAP_PHOTON_NUMBER_H

#include <stdint.h>

#include "base/rng.h"

/* Of this mean, below 2^53, by the seed and which number it is; 0 of mean 0.
 * resolution: standard deviation over the root of the mean; 1 is Poisson's distribution, any other
 * one normal, where the mean is above 10 (as Geant4 has it: Physics Reference Manual 11.2,
 * "Scintillation"). By portable operations; the time it takes is as the mean, up to 1e9, whence all
 * are normal. */
uint64_t rmap_photon_number(double mean, double resolution, uint64_t seed, uint64_t which);

/* Poisson's of this mean, by the draws of a slot from number *step on, which is advanced by those
 * that were taken. */
uint64_t rmap_poisson(double mean, uint64_t seed, uint64_t which, enum rmap_rng_slot slot,
                      uint32_t *step);

#endif
