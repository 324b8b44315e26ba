/* SPDX-License-Identifier: MIT
 *
 * What the coat of a surface makes of light that meets it.
 */
#include "scene/coat.h"

#include <math.h>

#include "base/portable.h"
#include "optics/fresnel.h"

/* Measured from outside; from the substrate the same at the angle that Snell's law leads to: the
 * share that passes is the same either way, and so is taken to be what is absorbed. */
static struct rmap_coat_shares measured(const struct rmap_thin_film *film, int channel,
                                        bool reversed, double n1, double n2, double cos_i)
{
    const double sine = sqrt((1.0 - cos_i) * (1.0 + cos_i)), beyond = sine * n1 / n2;
    if (!(beyond < 1.0))
        return (struct rmap_coat_shares){1.0, 0.0, true};
    const double angle = reversed
                             ? rmap_portable_angle(sqrt((1.0 - beyond) * (1.0 + beyond)), beyond)
                             : rmap_portable_angle(cos_i, sine);
    const double(*share)[2] = (const double(*)[2])film->share + (size_t)channel * film->n_angle;
    size_t k = 0;
    while (k + 2 < film->n_angle && angle >= film->angle[k + 1])
        k++;
    const size_t next = k + 1 < film->n_angle ? k + 1 : k;
    double t = next > k ? (angle - film->angle[k]) / (film->angle[next] - film->angle[k]) : 0.0;
    t = t < 0.0 ? 0.0 : t < 1.0 ? t : 1.0;
    return (struct rmap_coat_shares){share[k][0] + t * (share[next][0] - share[k][0]),
                                     share[k][1] + t * (share[next][1] - share[k][1]), false};
}

struct rmap_coat_shares rmap_thin_film_coat(const struct rmap_scene *scene,
                                            const struct rmap_object *object, bool front,
                                            int channel, double n1, double n2, double cos_i)
{
    const struct rmap_surface *surface =
        &scene->surface[front ? object->surface_front : object->surface_back];
    const struct rmap_thin_film *film = &scene->film[surface->film];
    if (film->n_angle > 0)
        return measured(film, channel, front == rmap_thin_film_on_front(film, object), n1, n2,
                        cos_i);
    const struct rmap_thin_film_shares shares =
        rmap_thin_film_shares(film->layer + (size_t)channel * film->n_layer, film->n_layer,
                              front == rmap_thin_film_on_front(film, object), n1, n2, 0.0, cos_i);
    return (struct rmap_coat_shares){0.5 * (shares.rs + shares.rp), 0.5 * (shares.ts + shares.tp),
                                     shares.total};
}

double rmap_metal_coat(const struct rmap_scene *scene, const struct rmap_surface *surface,
                       int channel, double n1, double cos_i)
{
    const double n = surface->metal_n[channel], k = surface->metal_k[channel];
    if (surface->coat != RMAP_COAT_FILM)
        return rmap_fresnel_metal(n1, n, k, cos_i);
    const struct rmap_thin_film *film = &scene->film[surface->film];
    if (film->n_angle > 0)
        return measured(film, channel, false, n1, (double)INFINITY, cos_i).reflected;
    const struct rmap_thin_film_shares shares = rmap_thin_film_shares(
        film->layer + (size_t)channel * film->n_layer, film->n_layer, false, n1, n, k, cos_i);
    return 0.5 * (shares.rs + shares.rp);
}
