/* SPDX-License-Identifier: MIT
 *
 * An energy balance as boxes and bands: sources, groups of the scene where there are many objects,
 * and where the light ended. What is small is merged, so that the sums stay whole.
 */
#ifndef RMAP_ENERGY_FLOW_H
#define RMAP_ENERGY_FLOW_H

#include "analysis/energy/energy.h"
#include "analysis/energy/sankey.h"

/* Fills nodes, links and columns of an empty sankey; places and scale are the caller's. */
enum rmap_status rmap_energy_flow(const struct rmap_energy *energy, struct rmap_sankey *sankey,
                                  struct rmap_error *err) RMAP_MUST_USE;

#endif
