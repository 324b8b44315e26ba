/* SPDX-License-Identifier: MIT */
#ifndef RMAP_DRAW_POLYDATA_H
#define RMAP_DRAW_POLYDATA_H

#include "analysis/figure/ray_paint.h"
#include "io/map/map_reader.h"

/* Rays of a map, which have all columns, as polylines with the groups that they are painted in. */
enum rmap_status rmap_draw_polydata(const struct rmap_map *map, const struct rmap_portion *rays,
                                    const struct rmap_ray_paint *paint, const char *path,
                                    struct rmap_error *err) RMAP_MUST_USE;

#endif
