/* SPDX-License-Identifier: MIT
 *
 * From a pixel into the scene.
 */
#ifndef RMAP_CAMERA_RAY_H
#define RMAP_CAMERA_RAY_H

#include "accel/accel.h"
#include "scene/scene.h"

/* The ray of pixel (x to the right, y down) of a picture of size[0] x size[1] pixels: u[0], u[1] in
 * [0, 1) its place in the pixel, u[2], u[3] on the lens. A thin lens images the plane at distance
 * `focus` without aberration, so all rays of one place in the picture meet there (Potmesil &
 * Chakravarty 1981, doi:10.1145/800224.806818). */
void rmap_camera_ray(const struct rmap_camera *camera, const uint32_t size[2], uint32_t x,
                     uint32_t y, const double u[4], struct rmap_ray *ray);

#endif
