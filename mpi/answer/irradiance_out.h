/* SPDX-License-Identifier: MIT
 *
 * Irradiance on objects as a file: a picture, a body for ParaView or a viewer of glTF, numbers.
 */
#ifndef RMAP_IRRADIANCE_OUT_H
#define RMAP_IRRADIANCE_OUT_H

#include "analysis/detector/irradiance_image.h"
#include "analysis/figure/value_scale.h"

struct rmap_irradiance_out {
    const char *title;
    enum rmap_irradiance_what what; /* that is shown in colours */
    enum rmap_figure_scale scale;
    const double *eye;                /* [2]; NULL: as suits */
    const struct rmap_camera *camera; /* NULL: none */
    bool over_texture;                /* pictures are of it, not of the bodies */
};

/* RMAP_SYSTEM; RMAP_USAGE beyond what a .glb holds. */
enum rmap_status rmap_irradiance_write(const struct rmap_irradiance_image *image,
                                       const struct rmap_irradiance_out *out, const char *path,
                                       struct rmap_error *err) RMAP_MUST_USE;

#endif
