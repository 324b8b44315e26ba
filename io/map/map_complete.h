/* SPDX-License-Identifier: MIT
 *
 * The tally of an incomplete map: that of its index, and of what stands beside it.
 */
#ifndef RMAP_MAP_COMPLETE_H
#define RMAP_MAP_COMPLETE_H

#include "io/map/map_reader.h"

enum rmap_status rmap_map_open(const char *path, struct rmap_map **map_ret,
                               struct rmap_error *err) RMAP_MUST_USE;

#endif
