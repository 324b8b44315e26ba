/* SPDX-License-Identifier: MIT
 *
 * raymap report MAP --energy: where the light went.
 */
#ifndef RMAP_ENERGY_RUN_H
#define RMAP_ENERGY_RUN_H

#include "analysis/energy/energy.h"
#include "mpi/command/command.h"

/* Collective. Without a criterion the balance is that of the map's tally, and columns are read for
 * what planes registered alone. *sums_ret: on rank 0 (rmap_energy_sums_destroy), NULL on the
 * others; refers to *scope. */
enum rmap_status rmap_energy_run(const struct rmap_context *context, const struct rmap_map *map,
                                 const struct rmap_choice *choice, struct rmap_energy_scope *scope,
                                 struct rmap_energy_sums **sums_ret,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* Collective. The command. */
enum rmap_status rmap_report_energy(const struct rmap_context *context,
                                    const struct rmap_arguments *given,
                                    struct rmap_error *err) RMAP_MUST_USE;

#endif
