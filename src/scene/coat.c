/* SPDX-License-Identifier: MIT
 *
 * What the coat of a FRESNEL surface makes of light that meets it.
 */
#include "scene/coat.h"

struct rmap_coat_shares rmap_thin_film_coat(const struct rmap_scene *scene,
                                            const struct rmap_object *object, bool front,
                                            int channel, double n1, double n2, double cos_i)
{
    const struct rmap_surface *surface =
        &scene->surface[front ? object->surface_front : object->surface_back];
    const struct rmap_thin_film *film = &scene->film[surface->film];
    const struct rmap_thin_film_shares shares =
        rmap_thin_film_shares(film->layer + (size_t)channel * film->n_layer, film->n_layer,
                              front == rmap_thin_film_on_front(film, object), n1, n2, 0.0, cos_i);
    return (struct rmap_coat_shares){0.5 * (shares.rs + shares.rp), 0.5 * (shares.ts + shares.tp),
                                     shares.total};
}
