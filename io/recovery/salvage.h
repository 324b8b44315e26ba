/* SPDX-License-Identifier: MIT
 *
 * Making finished pieces of what killed writers left, so that no ray they made safe is traced
 * again.
 */
#ifndef RMAP_SALVAGE_H
#define RMAP_SALVAGE_H

#include "io/map/map_content.h"
#include "io/map/map_directory.h"
#include "io/map/map_reader.h"

struct rmap_salvaged {
    size_t n_piece; /* published */
    uint64_t n_ray;
    uint64_t n_portion_lost, n_ray_lost; /* whose rows are damaged */
    char first_lost[512];                /* names rays, file, dataset and chunk; or empty */
};

/* Publishes the rays that the map has of a leftover as a piece of the leftover's shard, under a
 * free number, appends it to `content`, and removes the leftover. The map is one that was opened
 * while it was incomplete and the leftover stood there; the leftovers of a map may be given to
 * several processes, each to one. One that commits nothing, or nothing that finished pieces do not
 * have, is removed alone. A kill at any moment loses nothing: at worst rays are there twice, which
 * the map's reader sorts out.
 *
 * RMAP_FORMAT: damaged, or of another scene, seed or version: it stays. RMAP_SYSTEM. */
enum rmap_status rmap_salvage(const struct rmap_map *map, const struct rmap_leftover *leftover,
                              struct rmap_map_content *content, struct rmap_salvaged *salvaged,
                              struct rmap_error *err) RMAP_MUST_USE;

/* Puts what was salvaged, by all processes, into the map's content, in place of its unfinished
 * pieces. RMAP_FORMAT, RMAP_SYSTEM: the map is only to be closed then. */
enum rmap_status rmap_map_add_salvaged(struct rmap_map *map,
                                       const struct rmap_map_content *salvaged,
                                       struct rmap_error *err) RMAP_MUST_USE;

#endif
