/* SPDX-License-Identifier: MIT
 *
 * Irradiance over the textures of objects: arrays and a picture.
 */
#ifndef RMAP_IRRADIANCE_UV_OUT_H
#define RMAP_IRRADIANCE_UV_OUT_H

#include "io/export/svg.h"
#include "io/hdf5/grid_h5.h"
#include "mpi/answer/irradiance_out.h"

enum { RMAP_IRRADIANCE_UV_ARRAYS = 5 };

struct rmap_irradiance_uv {
    double *data[RMAP_IRRADIANCE_UV_ARRAYS]; /* [n_part][rows][columns] */
    char name[2][40];
};

/* array: [RMAP_IRRADIANCE_UV_ARRAYS], of what uv holds, the quantity first. Zero uv before. */
enum rmap_status rmap_irradiance_uv_init(const struct rmap_irradiance_image *image,
                                         struct rmap_irradiance_uv *uv,
                                         struct rmap_grid_array *array,
                                         struct rmap_error *err) RMAP_MUST_USE;
void rmap_irradiance_uv_fini(struct rmap_irradiance_uv *uv);

/* Of the first object. */
enum rmap_status rmap_irradiance_uv_figure(const struct rmap_irradiance_image *image,
                                           const struct rmap_irradiance_out *out,
                                           struct rmap_svg **svg_ret,
                                           struct rmap_error *err) RMAP_MUST_USE;

#endif
