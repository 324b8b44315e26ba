/* SPDX-License-Identifier: MIT
 *
 * Light of a medium in which charged particles leave energy.
 */
#ifndef RMAP_SCINTILLATION_H
#define RMAP_SCINTILLATION_H

#include <stddef.h>

#include "optics/decay.h"
#include "optics/spectrum.h"

struct rmap_scintillation {
    double per_mev;    /* photons */
    double birks;      /* length unit of the scene per MeV */
    double resolution; /* standard deviation of the number of photons over the root of its mean */
    double share[RMAP_CHANNEL_MAX]; /* of the photons, per channel; sums to 1 */
    double rise_ns;
    struct rmap_decay decay;
};

/* Mean number of photons of a step: L dE / (1 + kB dE/dx) (Birks 1951,
 * doi:10.1088/0370-1298/64/10/303); of a deposit without a length, L dE. */
double rmap_scintillation_mean(const struct rmap_scintillation *medium, double energy_mev,
                               double length);

/* ns from the deposit to the emission of a photon, by three numbers in (0, 1). The density of a
 * component is (exp(-t/decay) - exp(-t/rise)) / (decay - rise): that of the sum of two exponential
 * delays. By portable operations. */
double rmap_scintillation_delay(const struct rmap_scintillation *medium, const double u[3]);

#endif
