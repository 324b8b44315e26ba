/* SPDX-License-Identifier: MIT
 *
 * From a pixel into the scene.
 */
#include "render/camera_ray.h"

#include "formula/azimuth.h"

static struct rmap_vec3 combine(const struct rmap_camera *camera, double right, double up,
                                double forward)
{
    return rmap_axpy(right, camera->right,
                     rmap_axpy(up, camera->up, rmap_scale(camera->forward, forward)));
}

void rmap_camera_ray(const struct rmap_camera *camera, const uint32_t size[2], uint32_t x,
                     uint32_t y, const double u[4], struct rmap_ray *ray)
{
    double pixel = 2.0 * camera->slope / (double)size[1];
    double right = ((double)x + u[0] - 0.5 * (double)size[0]) * pixel;
    double up = (0.5 * (double)size[1] - (double)y - u[1]) * pixel;
    ray->origin = camera->at;
    ray->medium = camera->medium;
    ray->gradient = camera->gradient;
    rmap_contact_clear(&ray->contact);
    if (camera->type == RMAP_CAMERA_PINHOLE) {
        ray->direction = rmap_normalize(combine(camera, right, up, 1.0));
        return;
    }
    double cosine, sine, radius = camera->aperture * sqrt(u[2]);
    rmap_azimuth(u[3], &cosine, &sine);
    struct rmap_vec3 lens = combine(camera, radius * cosine, radius * sine, 0.0);
    struct rmap_vec3 target =
        combine(camera, right * camera->focus, up * camera->focus, camera->focus);
    ray->origin = rmap_add(camera->at, lens);
    ray->direction = rmap_normalize(rmap_sub(target, lens));
}
