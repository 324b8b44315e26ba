/* SPDX-License-Identifier: MIT
 *
 * What the published pieces of a map hold, read from their tables of portions.
 */
#ifndef RMAP_MAP_SCAN_H
#define RMAP_MAP_SCAN_H

#include "io/map_format.h"

struct rmap_map_content {
    struct rmap_piece_info *piece; /* by shard and number */
    size_t n_piece;
    struct rmap_portion_info *portion; /* by first ray id */
    size_t n_portion, cap_portion;
    uint64_t n_row[RMAP_TABLE_COUNT];
    struct rmap_digest digest;
};

/* Looks at every piece on disk. Each must be complete, of this seed and scene; RMAP_FORMAT names
 * the one that is not, and portions that hold the same rays. */
enum rmap_status rmap_map_scan(const char *map_path, uint64_t seed, const char *scene_digest,
                               struct rmap_map_content *content,
                               struct rmap_error *err) RMAP_MUST_USE;
void rmap_map_content_fini(struct rmap_map_content *content);

/* Checks that portions lie in their pieces without gap or overlap, and sums them up. */
enum rmap_status rmap_map_content_check(struct rmap_map_content *content, const char *path,
                                        struct rmap_error *err) RMAP_MUST_USE;

#endif
