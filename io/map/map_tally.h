/* SPDX-License-Identifier: MIT
 *
 * The energy balance and the detectors' images in the index: /tally/... and /detector/NAME/...
 */
#ifndef RMAP_MAP_TALLY_H
#define RMAP_MAP_TALLY_H

#include "io/hdf5/h5.h"
#include "trace/tally.h"

enum rmap_status rmap_map_tally_write(struct rmap_h5 *h5, const struct rmap_tally *tally,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* A tally of the scene, filled from an open index. */
enum rmap_status rmap_map_tally_read(struct rmap_h5 *h5, const struct rmap_scene *scene,
                                     struct rmap_tally **tally_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;

#endif
