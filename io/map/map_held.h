/* SPDX-License-Identifier: MIT
 *
 * A map whose portions stand in memory as they were traced, with no file behind it: criteria,
 * statistics and images are asked of it as of any other.
 */
#ifndef RMAP_MAP_HELD_H
#define RMAP_MAP_HELD_H

#include "io/map/map_reader.h"

/* What a rank holds of it; zeroed: nothing. */
struct rmap_held {
    size_t n;                       /* portions of all ranks, in the order of their rays */
    struct rmap_portion_info *info; /* [n]; `shard` is the rank that has it */
    struct rmap_portion **portion;  /* [n]; NULL: another rank has it */
    int n_rank;
    uint64_t seed;
};
void rmap_held_fini(struct rmap_held *held);

/* A portion's row, of rank `rank`; without its digest, which is for those who ask. */
void rmap_held_describe(const struct rmap_portion *portion, int rank,
                        struct rmap_portion_info *info);

/* One without rays, of so many ranks. Takes the scene over on success. RMAP_SYSTEM. */
enum rmap_status rmap_map_hold(int n_rank, uint64_t seed, struct rmap_scene *scene,
                               struct rmap_map **map_ret, struct rmap_error *err) RMAP_MUST_USE;

/* Takes over, on success, what `more` has: rays of the same scene and seed, which come behind those
 * that the map has. The tally of theirs is added and stays the caller's. RMAP_SYSTEM: the map can
 * be closed and nothing else. */
enum rmap_status rmap_map_hold_more(struct rmap_map *map, struct rmap_held *more,
                                    const struct rmap_tally *tally,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* Bytes of this rank's portions. */
size_t rmap_map_held_nbytes(const struct rmap_map *map);
size_t rmap_held_nbytes(const struct rmap_portion *portion); /* of one */

/* Whether a map is one of these: a rank can read the portions of its own shard alone, */
bool rmap_map_is_held(const struct rmap_map *map);

/* and those that this brings: each stays as it is until the next. */
struct rmap_held_elsewhere {
    enum rmap_status (*fetch)(void *context, size_t portion,
                              const struct rmap_portion **portion_ret, struct rmap_error *err);
    void *context;
};
void rmap_map_set_elsewhere(const struct rmap_map *map, struct rmap_held_elsewhere elsewhere);

/* Of a map in memory. RMAP_INTERNAL: another rank has it, and nothing brings it. */
enum rmap_status rmap_map_held_portion(const struct rmap_map *map, size_t portion,
                                       const struct rmap_portion **portion_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;

#endif
