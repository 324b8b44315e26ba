/* SPDX-License-Identifier: MIT
 *
 * The view of all pieces as one, for people with h5py: virtual datasets in the index, one per
 * column, by relative file names. Missing pieces read as fill values without an error, so no
 * program of ours reads through it.
 */
#ifndef RMAP_MAP_VIEW_H
#define RMAP_MAP_VIEW_H

#include "io/map/map_format.h"
#include "io/map/map_space.h"

/* Writes /ray/..., /segment/..., /registration/... over the pieces in their order; colours once per
 * colour mode, where pieces of other colour spaces show fill values. With more than
 * RMAP_VIEW_PIECES_MAX pieces, or one that does not store columns, the root's attribute `view`
 * says why there is none. */
enum rmap_status rmap_map_view_write(struct rmap_h5 *h5, const struct rmap_scene *scene,
                                     const struct rmap_map_spaces *spaces,
                                     const struct rmap_map_content *content,
                                     struct rmap_error *err) RMAP_MUST_USE;

#endif
