/* SPDX-License-Identifier: MIT
 *
 * Objects in false colours of what their cells have as glTF: in metres, y upwards.
 */
#ifndef RMAP_IRRADIANCE_GLB_H
#define RMAP_IRRADIANCE_GLB_H

#include "analysis/figure/figure_draw.h"

/* A node for each object. A facet has points of its own, with its colour and, as _VALUE, its
 * number. path: binary, or JSON where it ends in .gltf; replaced when the whole is written. */
enum rmap_status rmap_irradiance_glb_write(const struct rmap_figure_cells *painted,
                                           const char *path, struct rmap_error *err) RMAP_MUST_USE;

#endif
