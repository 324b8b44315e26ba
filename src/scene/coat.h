/* SPDX-License-Identifier: MIT
 *
 * What the coat of a surface makes of light that meets it.
 */
#ifndef RMAP_COAT_H
#define RMAP_COAT_H

#include "scene/scene.h"

/* Shares of unpolarised light; what is left of 1 is absorbed. */
struct rmap_coat_shares {
    double reflected, passed;
    bool total; /* total internal reflection: the media allow nothing else, whatever films do */
};

/* On a channel, at a side of an object whose surface has a coat FILM, from index n1 into n2, cos_i
 * in [0, 1]. front: light comes from the object's front. */
struct rmap_coat_shares rmap_thin_film_coat(const struct rmap_scene *scene,
                                            const struct rmap_object *object, bool front,
                                            int channel, double n1, double n2, double cos_i);

/* Reflectance of a metal mirror, bare or with films on it, from index n1. */
double rmap_metal_coat(const struct rmap_scene *scene, const struct rmap_surface *surface,
                       int channel, double n1, double cos_i);

/* Whether the films' last layer lies on the object's front, not its back: as the film says, or else
 * on the side whose medium is not the one around the object. */
static inline bool rmap_thin_film_on_front(const struct rmap_thin_film *film,
                                           const struct rmap_object *object)
{
    return film->substrate == RMAP_SUBSTRATE_FRONT ||
           (film->substrate == RMAP_SUBSTRATE_INSIDE &&
            object->medium_front != object->medium_outside);
}

#endif
