/* SPDX-License-Identifier: MIT
 *
 * Heights z(x, y) over a plane that no conic and no even powers of r alone describe:
 *
 *   base     CONIC    c r^2 / (1 + sqrt(1 - (1 + k) c^2 r^2))
 *            BICONIC  (cx x^2 + cy y^2) / (1 + sqrt(1 - (1 + kx) cx^2 x^2 - (1 + ky) cy^2 y^2))
 *            TOROID   f(y) + C x^2 / (q + sqrt(q^2 - C^2 x^2)), q = 1 - C f(y): the profile f, a
 *                     conic of c[1] and k[1] and powers of y, turned about a line along y at
 *                     z = 1 / C (C = c[0]; 0: a cylindrical surface)
 *   powers   sum a_i r^i, i = 1 to 32 (of a TOROID: of y, in f)
 *   xy       sum a_ij (x / norm)^i (y / norm)^j
 *   zernike  sum a_nm R_n^|m|(u) cos m phi (m >= 0) or sin |m| phi, u = r / norm, phi from x to y
 *   qcon     u^4 sum a_m Q_m^con(u^2) (Forbes 2007, doi 10.1364/OE.15.005218)
 *   qbfs     u^2 (1 - u^2) / cosine sum a_m Q_m^bfs(u^2) (Forbes 2010, doi 10.1364/OE.18.019700),
 *            the cosine that of the base's slope: sqrt(1 - c^2 r^2) of a sphere
 *
 * All by + - * / and square roots alone, as what compact maps are decoded with must be.
 */
#ifndef RMAP_SAG_H
#define RMAP_SAG_H

#include "geometry/aperture.h"

#define RMAP_SAG_POWERS 32
#define RMAP_SAG_DEGREE 20 /* of x and y together; of a Zernike polynomial */
#define RMAP_SAG_TERMS  ((RMAP_SAG_DEGREE + 1) * (RMAP_SAG_DEGREE + 2) / 2)
#define RMAP_SAG_Q      32

enum rmap_sag_base { RMAP_SAG_CONIC, RMAP_SAG_BICONIC, RMAP_SAG_TOROID };

struct rmap_sag {
    enum rmap_sag_base base;
    double curvature[2], conic[2]; /* along x and y; of a CONIC both are equal */
    double power[RMAP_SAG_POWERS]; /* of r^(i + 1) */
    int n_power;
    double xy_norm, xy[RMAP_SAG_TERMS];           /* of x^i y^j at rmap_sag_term(i + j, j) */
    int n_xy;                                     /* degree + 1; 0: none */
    double zernike_norm, zernike[RMAP_SAG_TERMS]; /* at rmap_sag_term(n, (n + m) / 2), the norm of
                                                     its order in it */
    int n_zernike;                                /* largest n, + 1 */
    double qcon_norm, qcon[RMAP_SAG_Q];
    int n_qcon;
    double qbfs_norm, qbfs[RMAP_SAG_Q];
    int n_qbfs;
    bool fresnel; /* flat, with the normal of the profile */

    /* Made by rmap_sag_finish. */
    double qbfs_sum[RMAP_SAG_Q]; /* in Forbes's auxiliary polynomials P */
    double bend[3];   /* xx, xy, yy: no second derivative is greater, but for those of the base of a
                         CONIC and of power 1 */
    bool flat;        /* the surface is the plane z = 0 */
    double noise;     /* of sums that are much smaller than their terms */
    double low, high; /* z within the aperture, never too narrow */
    double far;       /* largest distance from the axis */
};

struct rmap_height {
    double z, x, y; /* and its derivatives */
};

static inline int rmap_sag_term(int degree, int k)
{
    return degree * (degree + 1) / 2 + k;
}

/* Of the profile; and of the surface, which is flat where that is a Fresnel's. Where the base has
 * ended it goes on as if the root were 0. */
struct rmap_height rmap_sag_profile(const struct rmap_sag *sag, double x, double y);
struct rmap_height rmap_sag_height(const struct rmap_sag *sag, double x, double y);

/* NULL, or what is wrong with the numbers over this aperture; then the rest is made. */
const char *rmap_sag_finish(struct rmap_sag *sag, const struct rmap_aperture *aperture);

/* Bound of the second derivative by t along a piece of the line p + t d. Squared distances from the
 * axis: at least `near` and at most `far` on the piece, at least `least` on the line. */
double rmap_sag_bend(const struct rmap_sag *sag, struct rmap_vec3 d, double least, double near,
                     double far);

/* Turned about z the profile is the same. */
bool rmap_sag_is_revolved(const struct rmap_sag *sag);

/* Second derivatives of its profile on the axis: xx, xy, yy; false where it is inclined there. */
bool rmap_sag_vertex(const struct rmap_sag *sag, double curvature[3]);

/* Nothing but z = 0, and no Fresnel surface. */
bool rmap_sag_is_plane(const struct rmap_sag *sag);

/* The numbers that Zernike orders are counted by, and the norm of each: false where there is none.
 * FRINGE: 1 to 37, of peak 1, 37 the 12th power (J. Wyant's); NOLL: 1 on, orthonormal (Noll 1976,
 * doi 10.1364/JOSA.66.000207); STANDARD: 0 on, orthonormal (ANSI Z80.28). */
enum rmap_zernike_order { RMAP_ZERNIKE_FRINGE, RMAP_ZERNIKE_NOLL, RMAP_ZERNIKE_STANDARD };
bool rmap_zernike_term(enum rmap_zernike_order order, int number, int *n, int *m, double *norm);

#endif
