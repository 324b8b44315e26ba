/* SPDX-License-Identifier: MIT
 *
 * Light of a medium in which charged particles leave energy.
 */
#include "optics/scintillation.h"

#include "base/portable.h"

double rmap_scintillation_mean(const struct rmap_scintillation *medium, double energy_mev,
                               double length)
{
    const double unquenched = medium->per_mev * energy_mev;
    return length > 0.0 ? unquenched / (1.0 + medium->birks * (energy_mev / length)) : unquenched;
}

double rmap_scintillation_delay(const struct rmap_scintillation *medium, const double u[3])
{
    if (medium->decay.n == 0)
        return 0.0;
    return rmap_decay_delay(&medium->decay, u[0], u[1]) - medium->rise_ns * rmap_portable_log(u[2]);
}
