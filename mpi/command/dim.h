/* SPDX-License-Identifier: MIT
 *
 * --dim and --maintenance: sources dimmed after the trace.
 */
#ifndef RMAP_DIM_H
#define RMAP_DIM_H

#include "io/map/map_dim.h"
#include "mpi/command/command.h"

/* Entries of an option table. */
#define RMAP_DIM_OPTIONS                                                                           \
    {"dim", 0, "SOURCE=F,...",                                                                     \
     "as if sources had so many times their flux, as lamp=0.5,sky=0 or down_*=0"},                 \
    {                                                                                              \
        "maintenance", 0, "F", "maintenance factor: so much of the flux of every source, as 0.8"   \
    }

/* What they say of a map; without them nothing changes. Before anything is asked of the map.
 * RMAP_USAGE, RMAP_INPUT with the nearest name. */
enum rmap_status rmap_dim_read(const struct rmap_arguments *given, struct rmap_map *map,
                               struct rmap_error *err) RMAP_MUST_USE;

/* And puts out everything but the sky. RMAP_INPUT where there is none, or none in lm.
 * horizontal_ret: the illuminance of the open ground by it, undimmed. */
enum rmap_status rmap_dim_to_daylight(struct rmap_map *map, double *horizontal_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* A line for people, where something was dimmed. */
void rmap_dim_print(const struct rmap_map *map);

#endif
