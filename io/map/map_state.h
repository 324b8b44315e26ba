/* SPDX-License-Identifier: MIT
 *
 * The state in which a process has a map open, for other processes of the same program. A map that
 * is being traced is another one at every moment: each process would find other rays beside its
 * index.
 */
#ifndef RMAP_MAP_STATE_H
#define RMAP_MAP_STATE_H

#include "io/map/map_reader.h"

/* Pieces, portions, sums. *blob_ret: rmap_free. */
enum rmap_status rmap_map_state_pack(const struct rmap_map *map, uint8_t **blob_ret,
                                     size_t *nbytes_ret, struct rmap_error *err) RMAP_MUST_USE;

/* Puts a map into that state. RMAP_SYSTEM when the index that it was opened from is of another map
 * (it was replaced); only to be closed then. */
enum rmap_status rmap_map_state_take(struct rmap_map *map, uint8_t *blob, size_t nbytes,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* The same by memory of io/file/shared_memory.h: filled by one process, and joined by as many as
 * share it, the first among them, so that the rows are there once. */
enum rmap_status rmap_map_state_share(const struct rmap_map *map, int fd,
                                      struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_map_state_join(struct rmap_map *map, int fd,
                                     struct rmap_error *err) RMAP_MUST_USE;

#endif
