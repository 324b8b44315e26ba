/* SPDX-License-Identifier: MIT
 *
 * A map asked as if only its first portions had been traced: rays are independent of each other and
 * their ids in no order of what they do, so that these are a fair sample of all.
 */
#ifndef RMAP_MAP_CUT_H
#define RMAP_MAP_CUT_H

#include "io/map/map_reader.h"

struct rmap_map_cut {
    struct rmap_map *map; /* borrowed */
    size_t n_portion;     /* of the whole map */
    uint64_t n_row[RMAP_TABLE_COUNT];
    double *emitted; /* [n_source] by all of it */
};

/* RMAP_USAGE: of a map of picked rays. rmap_map_cut_fini whatever happened. */
enum rmap_status rmap_map_cut_init(struct rmap_map_cut *cut, struct rmap_map *map,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* From now on the map has its first n_portion portions, from which fluxes follow. Its tally's
 * images and sums, its summary and its digest stay those of the whole. Not while a cursor is in
 * use. */
void rmap_map_cut_to(struct rmap_map_cut *cut, size_t n_portion);

/* The map is whole again. */
void rmap_map_cut_fini(struct rmap_map_cut *cut);

#endif
