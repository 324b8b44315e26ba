/* SPDX-License-Identifier: MIT
 *
 * Polygons with numbers of each as a VTK XML file (.vtp) that ParaView opens: version 1.0,
 * little-endian binary arrays of cell data in base64.
 */
#ifndef RMAP_POLYGONS_H
#define RMAP_POLYGONS_H

#include "base/vec.h"
#include "io/hdf5/grid_h5.h"

struct rmap_polygons {
    size_t n_polygon;
    const size_t *end;             /* [n_polygon]: corners behind its last */
    const struct rmap_vec3 *point; /* [end[n_polygon - 1]] corners, polygon by polygon */
    double unit_m;
};

/* array: [n_polygon] each. RMAP_SYSTEM. */
enum rmap_status rmap_polygons_write(const struct rmap_polygons *polygons,
                                     const struct rmap_grid_array *array, size_t n_array,
                                     const struct rmap_grid_text *text, size_t n_text,
                                     const char *path, struct rmap_error *err) RMAP_MUST_USE;

#endif
