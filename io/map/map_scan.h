/* SPDX-License-Identifier: MIT
 *
 * What the published pieces of a map hold, read from the pieces themselves.
 */
#ifndef RMAP_MAP_SCAN_H
#define RMAP_MAP_SCAN_H

#include "io/map/map_content.h"
#include "io/map/map_space.h"

/* Appends a sealed piece to the content (in space 0), and says where it belongs.
 * RMAP_FORMAT when it is damaged, unfinished or of another format. */
enum rmap_status rmap_piece_read(const char *map_path, int shard, int number,
                                 struct rmap_map_content *content,
                                 struct rmap_piece_origin *origin_ret,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* Looks at every piece on disk. Each must be complete, of this seed and scene and in one of the
 * spaces; RMAP_FORMAT names the one that is not, and portions that share some rays. */
enum rmap_status rmap_map_scan(const char *map_path, uint64_t seed, int32_t tracer_revision,
                               const char *scene_digest, const struct rmap_map_spaces *spaces,
                               struct rmap_map_content *content,
                               struct rmap_error *err) RMAP_MUST_USE;

/* Puts the piece that was appended last into its space. RMAP_FORMAT when it is of another seed,
 * scene or colour space. */
enum rmap_status rmap_piece_place(struct rmap_map_content *content,
                                  const struct rmap_piece_origin *origin, uint64_t seed,
                                  int32_t tracer_revision, const char *scene_digest,
                                  const struct rmap_map_spaces *spaces,
                                  struct rmap_error *err) RMAP_MUST_USE;

#endif
