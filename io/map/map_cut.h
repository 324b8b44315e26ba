/* SPDX-License-Identifier: MIT
 *
 * A map asked as if only its first portions had been traced: rays are independent of each other and
 * their ids in no order of what they do, so that these are a fair sample of all; but where they
 * come in an order.
 */
#ifndef RMAP_MAP_CUT_H
#define RMAP_MAP_CUT_H

#include "io/map/map_reader.h"

/* What an answer is of: the first rays, as many as made its errors small enough. */
struct rmap_map_part {
    double relative; /* error that was asked for, as a part of the answer; 0: all rays are asked */
    bool is_reached;
    uint64_t n_ray; /* that were asked, of all_rays */
    uint64_t all_rays;
};

/* "1 % reached, by the first 65,536 of 4,000,000 rays"; "" where all rays are asked, and of NULL.
 */
#define RMAP_MAP_PART_LEN 128
void rmap_map_part_text(const struct rmap_map_part *part, char text[RMAP_MAP_PART_LEN]);

struct rmap_map_cut {
    struct rmap_map *map; /* borrowed */
    size_t n_portion;     /* of the whole map */
    uint64_t n_row[RMAP_TABLE_COUNT];
    double *emitted;  /* [n_source] by all of it */
    bool is_in_order; /* rays of files and steps are, and those of runs in other colours: the first
                         are no sample */
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
