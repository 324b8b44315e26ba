/* SPDX-License-Identifier: MIT
 *
 * The picture of an energy balance: light from its sources over groups of the scene to what
 * absorbed it, and beside it what detectors registered. Small flows are drawn as one, with their
 * sum.
 */
#ifndef RMAP_FIGURE_ENERGY_H
#define RMAP_FIGURE_ENERGY_H

#include "analysis/energy/energy.h"
#include "io/export/svg.h"

enum rmap_status rmap_figure_energy(const struct rmap_energy *energy, struct rmap_svg **svg_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;

#endif
