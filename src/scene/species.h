/* SPDX-License-Identifier: MIT
 *
 * What is dissolved in a medium and absorbs light, to give some of it back at other wavelengths:
 * dyes, wavelength shifters, phosphors.
 */
#ifndef RMAP_SPECIES_H
#define RMAP_SPECIES_H

#include <stdbool.h>
#include <stddef.h>

#include "optics/decay.h"
#include "optics/spectrum.h"

struct rmap_species {
    char *name;
    double absorption[RMAP_CHANNEL_MAX]; /* per length unit; a part of the medium's */
    double yield[RMAP_CHANNEL_MAX];      /* photons given back per photon absorbed */
    double below[RMAP_CHANNEL_MAX];      /* share of them on this channel and those before it */
    bool redshift;                       /* at no shorter a wavelength than was absorbed */
    struct rmap_decay lifetime;
};

/* How flux is counted where wavelengths change. A ray's weight is its photons' worth over that at
 * emission. */
enum rmap_accounting {
    RMAP_ACCOUNTING_ENERGY, /* watts, or lumens */
    RMAP_ACCOUNTING_PHOTONS
};

#endif
