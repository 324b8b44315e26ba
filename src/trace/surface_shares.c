/* SPDX-License-Identifier: MIT
 *
 * What becomes of light at a side of an object, by share.
 */
#include "trace/surface_shares.h"

#include <math.h>

#include "optics/fresnel.h"
#include "scene/coat.h"
#include "trace/interact.h"

struct rmap_surface_shares rmap_surface_shares(const struct rmap_scene *scene,
                                               struct rmap_surface_side side, int channel,
                                               double n1, double n2, double cos_i)
{
    const struct rmap_surface *surface =
        &scene->surface[side.front ? side.object->surface_front : side.object->surface_back];
    struct rmap_surface_shares shares = {.reflect_specular = surface->reflect_specular[channel],
                                         .reflect_diffuse = surface->reflect_diffuse[channel],
                                         .transmit_specular = surface->transmit_specular[channel],
                                         .transmit_diffuse = surface->transmit_diffuse[channel]};
    bool total;
    if (surface->type == RMAP_SURFACE_FRESNEL && surface->coat == RMAP_COAT_FILM) {
        const struct rmap_coat_shares its =
            rmap_thin_film_coat(scene, side.object, side.front, channel, n1, n2, cos_i);
        shares.reflect_specular = its.reflected;
        shares.transmit_specular = its.passed;
    } else if (surface->type == RMAP_SURFACE_FRESNEL) {
        shares.reflect_specular = rmap_coated_reflectance(surface, channel, n1, n2, cos_i, &total);
        shares.transmit_specular = 1.0 - shares.reflect_specular;
    } else if (surface->is_metal) {
        shares.reflect_specular =
            rmap_fresnel_metal(n1, surface->metal_n[channel], surface->metal_k[channel], cos_i);
    }
    const double left = 1.0 - shares.reflect_specular - shares.reflect_diffuse -
                        shares.transmit_specular - shares.transmit_diffuse;
    shares.absorb = fabs(left) > 1e-13 ? left : 0.0; /* of rounding */
    return shares;
}

double rmap_medium_index(const struct rmap_scene *scene, int32_t medium, int channel)
{
    return medium < 0 || scene->medium[medium].field ? (double)NAN
                                                     : scene->medium[medium].n[channel];
}

struct rmap_surface_shares rmap_side_shares(const struct rmap_scene *scene,
                                            struct rmap_surface_side side, int channel,
                                            double angle_deg)
{
    const double front = rmap_medium_index(scene, side.object->medium_front, channel);
    const double back = rmap_medium_index(scene, side.object->medium_back, channel);
    return rmap_surface_shares(scene, side, channel, side.front ? front : back,
                               side.front ? back : front,
                               angle_deg < 90.0 ? cos(angle_deg * RMAP_PI / 180.0) : 0.0);
}
