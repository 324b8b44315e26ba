/* SPDX-License-Identifier: MIT
 *
 * Particles on a surface: spheres of the sizes of a cleanliness level (IEST-STD-CC1246), each of
 * which scatters light that passes it by Mie's theory, the angles about the specular direction.
 */
#ifndef RMAP_SCATTER_DUST_H
#define RMAP_SCATTER_DUST_H

#include "scatter/scatter.h"

/* As a scene says it: 10^(slope (log10(level)^2 - log10(d)^2)) particles per `area_um2` are larger
 * than d micrometres, d from 1 to twice the level. */
struct rmap_dust_kind {
    double level, slope, area_um2;
    double n[RMAP_CHANNEL_MAX], k[RMAP_CHANNEL_MAX]; /* index of a particle */
};

struct rmap_scatter_dust {
    size_t n_ring;
    double *edge;    /* [n_ring + 1] squared sines of half the angle of scatter */
    double *density; /* [n_channel][n_ring] of light scattered once, 1/sr over the sphere */
    double *below;   /* [n_channel][n_ring]: its integral up to and with the ring */
    double *onward;  /* [n_channel][RMAP_TOTAL_STEPS + 1]: share that goes on, beyond the plane of
                        the surface, of light at cos = (k / RMAP_TOTAL_STEPS)^2 to it */
    double coverage; /* share of the area */
    struct rmap_dust_kind kind;
};

/* Fills the model's shape (optical thickness of one crossing) and dust; spheres of one of `others`
 * of the same kind, whose channels are these, are taken over. */
enum rmap_status rmap_scatter_set_dust(struct rmap_scatter *scatter,
                                       const struct rmap_dust_kind *kind,
                                       const struct rmap_channels *channels,
                                       const struct rmap_scatter *others, size_t n_other,
                                       struct rmap_error *err) RMAP_MUST_USE;
void rmap_scatter_dust_destroy(struct rmap_scatter_dust *dust);

/* Of light that particles scatter, the share that goes on beyond a plane at this cosine to it. */
double rmap_dust_onward(const struct rmap_scatter *scatter, int channel, double cosine);

/* What lobe.c asks. The shape and its integral hold the weights `ahead` and `back`. */
double rmap_dust_shape(const struct rmap_scattering *at, struct rmap_vec3 out);
double rmap_dust_total(const struct rmap_scattering *at);
struct rmap_vec3 rmap_dust_draw(const struct rmap_scattering *at, const struct rmap_draw *draw);

#endif
