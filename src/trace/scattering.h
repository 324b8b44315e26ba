/* SPDX-License-Identifier: MIT
 *
 * Light at a surface that has a scatter model. A lobe takes its share of what is reflected, or of
 * what passes, by the angle of incidence; facets are drawn first, and what becomes of the light is
 * decided at one of them. The tracer, the decoder of compact maps and the renderer ask here.
 */
#ifndef RMAP_SCATTERING_H
#define RMAP_SCATTERING_H

#include "scene/coat.h"
#include "trace/surface_shares.h"

/* A side that light meets, on a channel. */
struct rmap_scatter_side {
    const struct rmap_scene *scene;
    const struct rmap_object *object;
    bool front;
    struct rmap_vec3 position; /* in the world, and triangle: where u grows */
    int32_t primitive;
    const struct rmap_surface *surface;
    bool portable;     /* bare metals of numbers that are the same bits on every machine */
    int32_t near, far; /* media */
    int channel;
    double n1, n2;                 /* on it */
    struct rmap_vec3 x, y, normal; /* its frame: rmap_scatter_frame; normal towards the light */
};

/* What a smooth boundary of this kind reflects and lets pass: by the coat, by the metal, or as the
 * scene file says. */
struct rmap_coat_shares rmap_smooth_shares(const struct rmap_scatter_side *side, double cos_i);

/* Shares of all that may happen to light that travels along `in`, in the side's frame; of facets by
 * quadrature, which takes a millisecond. */
struct rmap_surface_shares rmap_scatter_shares(const struct rmap_scatter_side *side,
                                               struct rmap_vec3 in);

/* reflect_specular of these, without a quadrature. */
double rmap_scatter_reflectance(const struct rmap_scatter_side *side, struct rmap_vec3 in);

/* The numbers of what is reflected, or passes, are the same bits on every machine and follow from
 * the angle of incidence, at a facet where it is of facets: no table, no particles beyond a
 * boundary; bare metals and facets of a boundary only of a portable side, since the tracer asks
 * others. What the decoder of compact maps weighs colours with. */
bool rmap_scatter_shares_follow(const struct rmap_scatter_side *side, bool passes);

/* Does what is reflected, or passes, depend on the angle at facets? Then rmap_facet_meet has it. */
bool rmap_scatter_by_facet(const struct rmap_scatter_side *side);

/* x and y across the normal: of an anisotropic model from the object's x axis (its y, where the
 * normal is along x), seen from its front; or x where u grows: along a mesh's texture, around the z
 * axis of what is round, along a rectangle's x. */
void rmap_scatter_frame(struct rmap_scatter_side *side);

/* Is the direction that light is scattered to one of the channel? */
bool rmap_scatter_by_channel(const struct rmap_scatter_side *side, const struct rmap_scatter *its);

/* Facets: one of them, and what light does there. */
enum rmap_facet_part { RMAP_PART_SPIKE, RMAP_PART_LOBE, RMAP_PART_BACK, RMAP_PART_LAMBERT };
struct rmap_facet {
    enum rmap_facet_part part;   /* UNIFIED; else LOBE */
    struct rmap_vec3 in, normal; /* in the side's frame */
    double cos_i;                /* at which the smooth boundary is asked */
};
void rmap_facet_meet(const struct rmap_scatter_side *side, struct rmap_vec3 direction,
                     const struct rmap_draw *draw, struct rmap_facet *facet);
/* The direction in the world after a diffuse event, and the share of it that is not in another
 * facet's way: 0 where there is none. */
double rmap_facet_leave(const struct rmap_scatter_side *side, const struct rmap_facet *facet,
                        bool passes, const struct rmap_draw *draw, struct rmap_vec3 *out);

/* Of models beside each other the one that scatters light which travels along `direction`; NULL:
 * the side has none. */
const struct rmap_scatter *rmap_scatter_picked(const struct rmap_scatter_side *side, bool passes,
                                               struct rmap_vec3 direction,
                                               const struct rmap_draw *draw);

/* The direction in the world after a diffuse event of the side's model. */
struct rmap_vec3 rmap_scatter_turned(const struct rmap_scatter_side *side, bool passes,
                                     struct rmap_vec3 direction, const struct rmap_draw *draw);

/* BSDF, 1/sr, from one direction of travel to another; 0 of what goes one way alone (a unified
 * model's spike and back-scatter). */
double rmap_scatter_bsdf(const struct rmap_scatter_side *side, struct rmap_vec3 in,
                         struct rmap_vec3 out);

#endif
