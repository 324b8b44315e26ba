/* SPDX-License-Identifier: MIT
 *
 * Numbers of the voxels of a box as a VTK XML file (.vti) that ParaView opens: version 1.0,
 * little-endian binary arrays of cell data in base64.
 */
#ifndef RMAP_IMAGE_DATA_H
#define RMAP_IMAGE_DATA_H

#include <stdint.h>

#include "io/hdf5/grid_h5.h"

struct rmap_image_data {
    uint32_t n[3];
    double low[3], step[3]; /* of the box, in the scene's unit */
    double unit_m;
};

/* array: [n[2]][n[1]][n[0]] each; others are left out. RMAP_SYSTEM. */
enum rmap_status rmap_image_data_write(const struct rmap_image_data *box,
                                       const struct rmap_grid_array *array, size_t n_array,
                                       const struct rmap_grid_text *text, size_t n_text,
                                       const char *path, struct rmap_error *err) RMAP_MUST_USE;

#endif
