/* SPDX-License-Identifier: MIT
 *
 * Writing rays of an open map again: what its files say of their origin stays as it is.
 */
#ifndef RMAP_MAP_RUN_H
#define RMAP_MAP_RUN_H

#include "io/map/map_writer.h"

/* run borrows from the map and from the rest. */
struct rmap_map_run {
    struct rmap_run run;
    struct rmap_bundle bundle;   /* the map's, with the options of the space */
    struct rmap_bundle *options; /* owns them */
};

/* A run in one of the map's colour spaces. RMAP_FORMAT, RMAP_SYSTEM. */
enum rmap_status rmap_map_run_init(const struct rmap_map *map, size_t space,
                                   enum rmap_encoding encoding, struct rmap_map_run *self,
                                   struct rmap_error *err) RMAP_MUST_USE;
void rmap_map_run_fini(struct rmap_map_run *self); /* zeroed: fine */

/* That the scene inside is, in every colour space, the one that the digests name. RMAP_FORMAT says
 * which is not; RMAP_SYSTEM. */
enum rmap_status rmap_map_check_scene(const struct rmap_map *map,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
