/* SPDX-License-Identifier: MIT
 *
 * What becomes of light at a surface: one outcome drawn with its physical probability (analog Monte
 * Carlo).
 */
#ifndef RMAP_INTERACT_H
#define RMAP_INTERACT_H

#include "accel/accel.h"
#include "base/rng.h"
#include "optics/fresnel.h"
#include "scene/scene.h"
#include "trace/colour.h"

struct rmap_decision {
    uint32_t events;            /* what happened; ABSORB and ERROR end the ray */
    bool turned;                /* goes on, on the side it came from */
    int32_t medium;             /* it goes on in */
    int32_t gradient;           /* 1 + index of the gradient medium in place; 0: uniform */
    struct rmap_vec3 direction; /* unit, if it goes on */
    int collapse;               /* channel drawn, or -1 */
    bool predicted;             /* as in struct rmap_hit, of direction and colour */
    bool sharp;                 /* of a diffuse event: one direction alone was possible */
    const double *weigh; /* probabilities that the colour is to be weighed with, or NULL; may point
                            into `scratch` */
    double scratch[RMAP_CHANNEL_MAX];
};

/* Decides at the surface of `hit`; changes nothing but *decision. The light's medium must be that
 * of the side it meets (or that side RMAP_MEDIUM_ANY), and a gradient medium must have an index
 * there: else the event is ERROR. */
void rmap_interact(const struct rmap_scene *scene, const struct rmap_ray *ray,
                   const struct rmap_hit *hit, const struct rmap_colour *colour,
                   const struct rmap_draw *draw, struct rmap_decision *decision);

/* Reflectance of a FRESNEL surface without thin films on a channel, unpolarised, from index n1 into
 * n2 at cos_i in [0, 1]; *total: total internal reflection. */
static inline double rmap_coated_reflectance(const struct rmap_surface *surface, int channel,
                                             double n1, double n2, double cos_i, bool *total)
{
    struct rmap_fresnel f = rmap_fresnel_dielectric(n1, n2, cos_i);
    *total = f.total;
    if (f.total)
        return 1.0;
    switch (surface->coat) {
    case RMAP_COAT_REFLECTANCE:
        return surface->reflect_specular[channel];
    case RMAP_COAT_IDEAL:
        return 0.0;
    case RMAP_COAT_NONE:
    case RMAP_COAT_FILM: /* scene/coat.h */
        break;
    }
    return 0.5 * (f.rs + f.rp);
}

/* Brings the colour from before the surface to after it. */
void rmap_decision_apply(const struct rmap_decision *decision, struct rmap_colour *colour);

#endif
