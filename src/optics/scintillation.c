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
    if (medium->n_decay == 0)
        return 0.0;
    size_t k = 0;
    for (double below = medium->decay[0].share; k + 1 < medium->n_decay && below <= u[0];)
        below += medium->decay[++k].share;
    return -(medium->decay[k].time_ns * rmap_portable_log(u[1]) +
             medium->rise_ns * rmap_portable_log(u[2]));
}
