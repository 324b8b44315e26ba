/* SPDX-License-Identifier: MIT
 *
 * --receivers FILE of a command that asks a map.
 */
#ifndef RMAP_OVERLAY_LOAD_H
#define RMAP_OVERLAY_LOAD_H

#include "analysis/overlay/overlay.h"
#include "mpi/command/command.h"

/* In an option table. */
#define RMAP_RECEIVERS_OPTION                                                                      \
    {                                                                                              \
        "receivers", 0, "FILE",                                                                    \
            "lay detectors over the map that the scene did not have: their list, as in a scene"    \
    }

/* Collective. Without --receivers *overlay_ret is NULL. Rank 0 reads the file and prints its
 * mistakes, each with file:line:column, and every rank lays the same receivers over the map, which
 * must outlive them (rmap_overlay_destroy before rmap_map_close). What a command does with it:
 *
 *     RMAP_TRY(rmap_load_map(context, path, &map, err));
 *     RMAP_TRY(rmap_overlay_load(context, given, map, &overlay, err));
 *     const struct rmap_scene *scene = rmap_scene_with(map, overlay);
 *
 * From then on names are looked up and criteria compiled in that scene instead of
 * rmap_map_scene(map), and the overlay is handed to the fold (fold.overlay). Detector indices from
 * rmap_overlay_first on are receivers: the map's tally has none of them. */
enum rmap_status rmap_overlay_load(const struct rmap_context *context,
                                   const struct rmap_arguments *given, const struct rmap_map *map,
                                   struct rmap_overlay **overlay_ret,
                                   struct rmap_error *err) RMAP_MUST_USE;

#endif
