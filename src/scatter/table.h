/* SPDX-License-Identifier: MIT
 *
 * A measured BSDF: constant over patches of the hemisphere into which light goes, about the normal
 * or about the specular direction; from the patch that it came in (Klems 1994, ASHRAE Trans. 100
 * (1) 1065), or between the angles of incidence that were measured, linear.
 */
#ifndef RMAP_SCATTER_TABLE_H
#define RMAP_SCATTER_TABLE_H

#include "scatter/scatter.h"

/* Rings, each of equal patches, the first of which is centred at azimuth 0. About the normal a
 * patch goes by the tangential part of a direction of travel; about the specular direction azimuth
 * 0 is towards the normal. */
struct rmap_patches {
    size_t n_ring, n;
    double *sin2;  /* [n_ring + 1] edges: squares of sines, of half the angle from the specular
                      direction, ascending; the first is 0 */
    size_t *first; /* [n_ring + 1] patch */
    size_t *ring;  /* [n] of each patch */
};

/* One side of the surface: BSDF of every incidence and outgoing patch. */
struct rmap_scatter_block {
    double *value; /* [n_band][n_in][out.n], 1/sr; NULL: nothing */
    double *below; /* the same: integral of BSDF x cosine over the patches up to and with this */
    double *total; /* [n_band][n_in] */
    double *fit;   /* about the specular direction: [n_band][n_in][RMAP_TABLE_FITS], the total if
                      light came at angles from the incidence before to that behind */
};
enum { RMAP_TABLE_FITS = 17 };

struct rmap_scatter_table {
    struct rmap_patches out;
    bool about_specular;
    bool by_patch;          /* incidence is a patch of `out`; else: */
    size_t n_theta, n_turn; /* by angles, and by equal turns of the surface; n_turn 1: isotropic,
                               and outgoing azimuths are about the plane of incidence */
    double first_turn;      /* azimuth of the light's travel in the first of them, in turns */
    double *theta;          /* [n_theta] radians, ascending */
    size_t n_in, n_band;    /* n_band: 1, or the number of channels */
    struct rmap_scatter_block block[2]; /* of light from the back, from the front */
};

/* Values zero, for the caller to fill. ring_deg: [n_ring + 1]; n_phi: [n_ring], or NULL:
 * n_phi_each in every ring; theta_deg: [n_theta] or NULL with n_theta 0: by patch. */
struct rmap_scatter_table_shape {
    size_t n_ring;
    const double *ring_deg;
    const size_t *n_phi;
    size_t n_phi_each;
    size_t n_theta;
    const double *theta_deg;
    size_t n_turn, n_band;
    double first_turn; /* 0 <= it < 1 */
    bool side[2];      /* which blocks there are: back, front */
    bool about_specular;
};
enum rmap_status rmap_scatter_table_create(const struct rmap_scatter_table_shape *shape,
                                           struct rmap_scatter_table **table_ret,
                                           struct rmap_error *err) RMAP_MUST_USE;
/* Once its values are set; passes: they are of transmitted light. The greatest total, and the
 * incidence of it in degrees. */
double rmap_scatter_table_finish(struct rmap_scatter_table *table, bool passes,
                                 double *theta_deg_ret);
void rmap_scatter_table_destroy(struct rmap_scatter_table *table);

/* What lobe.c asks of it. */
double rmap_table_shape(const struct rmap_scattering *at, struct rmap_vec3 out);
double rmap_table_total(const struct rmap_scattering *at);
struct rmap_vec3 rmap_table_draw(const struct rmap_scattering *at, const struct rmap_draw *draw);

/* Mean of |f(a, b) - f(b, a)| over that of f, cosines weighed, over pairs of directions: 0 where it
 * is reciprocal. NaN where light of the other side has no data. */
double rmap_table_asymmetry(const struct rmap_scatter *scatter, int channel, bool passes,
                            bool front);

#endif
