/* SPDX-License-Identifier: MIT
 *
 * What becomes of light at a side of an object, by share.
 */
#include "trace/surface_shares.h"

#include <math.h>

#include "optics/fresnel.h"
#include "scene/coat.h"
#include "trace/interact.h"

static double index_of(const struct rmap_scene *scene, int32_t medium, int channel)
{
    return medium < 0 || scene->medium[medium].field ? (double)NAN
                                                     : scene->medium[medium].n[channel];
}

static void fresnel(const struct rmap_scene *scene, const struct rmap_object *object, bool front,
                    int channel, double cos_i, struct rmap_surface_shares *shares)
{
    const struct rmap_surface *surface =
        &scene->surface[front ? object->surface_front : object->surface_back];
    const double a = index_of(scene, object->medium_front, channel);
    const double b = index_of(scene, object->medium_back, channel);
    const double n1 = front ? a : b, n2 = front ? b : a;
    bool total;
    if (surface->coat == RMAP_COAT_FILM) {
        const struct rmap_coat_shares its =
            rmap_thin_film_coat(scene, object, front, channel, n1, n2, cos_i);
        shares->reflect_specular = its.reflected;
        shares->transmit_specular = its.passed;
        return;
    }
    shares->reflect_specular = rmap_coated_reflectance(surface, channel, n1, n2, cos_i, &total);
    shares->transmit_specular = 1.0 - shares->reflect_specular;
}

struct rmap_surface_shares rmap_surface_shares(const struct rmap_scene *scene,
                                               const struct rmap_object *object, bool front,
                                               int channel, double cos_i)
{
    const struct rmap_surface *surface =
        &scene->surface[front ? object->surface_front : object->surface_back];
    struct rmap_surface_shares shares = {.reflect_specular = surface->reflect_specular[channel],
                                         .reflect_diffuse = surface->reflect_diffuse[channel],
                                         .transmit_specular = surface->transmit_specular[channel],
                                         .transmit_diffuse = surface->transmit_diffuse[channel]};
    if (surface->type == RMAP_SURFACE_FRESNEL)
        fresnel(scene, object, front, channel, cos_i, &shares);
    else if (surface->is_metal)
        shares.reflect_specular = rmap_fresnel_metal(
            index_of(scene, front ? object->medium_front : object->medium_back, channel),
            surface->metal_n[channel], surface->metal_k[channel], cos_i);
    const double left = 1.0 - shares.reflect_specular - shares.reflect_diffuse -
                        shares.transmit_specular - shares.transmit_diffuse;
    shares.absorb = fabs(left) > 1e-13 ? left : 0.0; /* of rounding */
    return shares;
}
