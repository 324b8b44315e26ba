/* SPDX-License-Identifier: MIT
 *
 * What every file of a map says of its origin, as attributes of its root.
 */
#ifndef RMAP_PROVENANCE_H
#define RMAP_PROVENANCE_H

#include "io/hdf5/h5.h"
#include "io/map/map_content.h"
#include "io/map/map_writer.h"

/* The bundle as a map carries it: packed, with the scene file's name in place of its whole path,
 * so that equal scenes make equal maps wherever they lie. *blob_ret: rmap_free. */
enum rmap_status rmap_scene_pack(const struct rmap_bundle *bundle, uint8_t **blob_ret,
                                 size_t *nbytes_ret, struct rmap_error *err) RMAP_MUST_USE;

/* Where the pieces of a run belong. The scene's digest is XXH3-128 over the packed bundle without
 * what chooses the colour space alone (--color, --set of spectrum... and simulations...color), so
 * that rays in different ones may stand in one map; the space's digest is over all of it. */
enum rmap_status rmap_piece_origin_of(const struct rmap_run *run, struct rmap_piece_origin *origin,
                                      struct rmap_error *err) RMAP_MUST_USE;

enum rmap_status rmap_provenance_put(struct rmap_h5 *h5, const char *filetype,
                                     const struct rmap_run *run,
                                     const struct rmap_piece_origin *origin,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* Checks filetype and version of an open file. RMAP_FORMAT, with what to do. */
enum rmap_status rmap_provenance_check(struct rmap_h5 *h5, const char *filetype,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Of an open file; 1 where it does not say. */
enum rmap_status rmap_tracer_revision_read(struct rmap_h5 *h5, int32_t *revision_ret,
                                           struct rmap_error *err) RMAP_MUST_USE;

/* Whether an open file is of a map with /curve. */
bool rmap_provenance_is_curved(struct rmap_h5 *h5);

#endif
