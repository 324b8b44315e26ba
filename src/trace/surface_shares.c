/* SPDX-License-Identifier: MIT
 *
 * What becomes of light at a side of an object, by share.
 */
#include "trace/surface_shares.h"

#include <math.h>

#include "trace/scattering.h"

static struct rmap_scatter_side side_of(const struct rmap_scene *scene,
                                        struct rmap_surface_side side, int channel, double n1,
                                        double n2)
{
    const struct rmap_object *object = side.object;
    return (struct rmap_scatter_side){
        .scene = scene,
        .object = object,
        .front = side.front,
        .surface = &scene->surface[side.front ? object->surface_front : object->surface_back],
        .near = side.front ? object->medium_front : object->medium_back,
        .far = side.front ? object->medium_back : object->medium_front,
        .channel = channel,
        .n1 = n1,
        .n2 = n2};
}

static struct rmap_vec3 towards(double cos_i)
{
    return rmap_vec3(sqrt((1.0 - cos_i) * (1.0 + cos_i)), 0.0, -cos_i);
}

double rmap_surface_reflectance(const struct rmap_scene *scene, struct rmap_surface_side side,
                                int channel, double n1, double n2, double cos_i)
{
    const struct rmap_scatter_side its = side_of(scene, side, channel, n1, n2);
    return rmap_surface_scatters(its.surface) ? rmap_scatter_reflectance(&its, towards(cos_i))
                                              : rmap_smooth_shares(&its, cos_i).reflected;
}

struct rmap_surface_shares rmap_surface_shares(const struct rmap_scene *scene,
                                               struct rmap_surface_side side, int channel,
                                               double n1, double n2, double cos_i)
{
    const struct rmap_scatter_side its = side_of(scene, side, channel, n1, n2);
    const struct rmap_surface *surface = its.surface;
    struct rmap_surface_shares shares;
    if (rmap_surface_scatters(surface)) {
        shares = rmap_scatter_shares(&its, towards(cos_i));
    } else {
        const struct rmap_coat_shares smooth = rmap_smooth_shares(&its, cos_i);
        shares =
            (struct rmap_surface_shares){.reflect_specular = smooth.reflected,
                                         .reflect_diffuse = surface->reflect_diffuse[channel],
                                         .transmit_specular = smooth.passed,
                                         .transmit_diffuse = surface->transmit_diffuse[channel]};
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

/* Indices of a side's media; an opaque side's that are not stated: 1. */
static void indices(const struct rmap_scene *scene, struct rmap_surface_side side, int channel,
                    double *n1, double *n2)
{
    const int32_t near = side.front ? side.object->medium_front : side.object->medium_back,
                  far = side.front ? side.object->medium_back : side.object->medium_front;
    *n1 = near == RMAP_MEDIUM_ANY ? 1.0 : rmap_medium_index(scene, near, channel);
    *n2 = far == RMAP_MEDIUM_ANY ? *n1 : rmap_medium_index(scene, far, channel);
}

double rmap_side_bsdf(const struct rmap_scene *scene, struct rmap_surface_side side, int channel,
                      double incidence_deg, double scatter_deg, bool passes)
{
    const double in = incidence_deg * RMAP_PI / 180.0, out = scatter_deg * RMAP_PI / 180.0;
    double n1, n2;
    indices(scene, side, channel, &n1, &n2);
    struct rmap_scatter_side its = side_of(scene, side, channel, n1, n2);
    its.x = rmap_vec3(1.0, 0.0, 0.0);
    its.y = rmap_vec3(0.0, 1.0, 0.0);
    its.normal = rmap_vec3(0.0, 0.0, 1.0);
    return rmap_scatter_bsdf(&its, rmap_vec3(sin(in), 0.0, -cos(in)),
                             rmap_vec3(sin(out), 0.0, passes ? -cos(out) : cos(out)));
}

struct rmap_surface_shares rmap_side_shares(const struct rmap_scene *scene,
                                            struct rmap_surface_side side, int channel,
                                            double angle_deg)
{
    double n1, n2;
    indices(scene, side, channel, &n1, &n2);
    return rmap_surface_shares(scene, side, channel, n1, n2,
                               angle_deg < 90.0 ? cos(angle_deg * RMAP_PI / 180.0) : 0.0);
}
