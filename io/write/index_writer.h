/* SPDX-License-Identifier: MIT
 *
 * map.h5: everything about a map but its columns. Replaced whole by rename, so a map has an index
 * at every moment once it had one.
 */
#ifndef RMAP_INDEX_WRITER_H
#define RMAP_INDEX_WRITER_H

#include "io/map/map_writer.h"

/* Writes map.h5, over an old one if there is one: at the start of a trace (incomplete, without
 * pieces), so that what a killed trace leaves is a map, and at its end. run->space must be the
 * number that rmap_map_admit gave (0 in a new map). RMAP_FORMAT: pieces share some rays. */
enum rmap_status rmap_index_write_content(const char *map_path, const struct rmap_index *index,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* The same for a map of one run, from the shards that stand in the map's directory and the merged
 * tally: for those who have no content at hand. Reads every piece's tables. RMAP_FORMAT also when
 * one is damaged or foreign. */
enum rmap_status rmap_index_write(const char *map_path, const struct rmap_run *run,
                                  const struct rmap_tally *tally, bool complete,
                                  struct rmap_error *err) RMAP_MUST_USE;

/* Whether a run may add rays to a map: same scene, seed and instruction set. RMAP_INPUT says what
 * differs. *space_ret: number of the run's colour space in the map, for run->space; one more than
 * the map has if it is new. */
enum rmap_status rmap_map_admit(const struct rmap_map *map, const struct rmap_run *run,
                                int32_t *space_ret, struct rmap_error *err) RMAP_MUST_USE;

#endif
