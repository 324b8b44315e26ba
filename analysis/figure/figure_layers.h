/* SPDX-License-Identifier: MIT
 *
 * The nearest faces of bodies, pixel by pixel at twice the picture's resolution: bodies, what is of
 * glass, and what is painted for themselves.
 */
#ifndef RMAP_FIGURE_LAYERS_H
#define RMAP_FIGURE_LAYERS_H

#include <stdint.h>

#include "analysis/figure/figure_solid.h"

struct rmap_solid_pixel {
    float depth; /* towards the eye */
    uint32_t object;
    int8_t normal[3]; /* x 127, view coordinates */
    uint8_t shade;
    uint32_t paint; /* 1 + cell whose colour it has; 0: as its object looks */
};

enum rmap_solid_layer { RMAP_LAYER_BODY, RMAP_LAYER_GLASS, RMAP_LAYER_PAINTED, RMAP_LAYER_COUNT };

struct rmap_solid {
    const struct rmap_scene *scene;
    const struct rmap_view_frame *frame;
    const struct rmap_painted *painted; /* NULL: none */
    int width, height;                  /* pixels of the layers */
    double scale;                       /* of them per picture pixel */
    double (*tint)[3];                  /* [n_object] sRGB of faces in full light, 0 to 1 */
    struct rmap_solid_pixel
        *pixel[RMAP_LAYER_COUNT]; /* the nearest faces; glass, painted: NULL without any */
    float nearest, farthest;      /* depths */
};

#endif
