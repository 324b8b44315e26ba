/* SPDX-License-Identifier: MIT
 *
 * Shapes of CODE V's surfaces that are not of revolution, or have coefficients by number.
 */
#ifndef RMAP_LENS_SEQ_SHAPE_H
#define RMAP_LENS_SEQ_SHAPE_H

#include "io/lensfile/prescription.h"

enum rmap_seq_form {
    RMAP_SEQ_PLAIN, /* SPH, CON, ASP */
    RMAP_SEQ_ANAMORPHIC,
    RMAP_SEQ_CYLINDER,
    RMAP_SEQ_Y_TOROID,
    RMAP_SEQ_X_TOROID,
    RMAP_SEQ_ODD,
    RMAP_SEQ_XY,
    RMAP_SEQ_ZERNIKE, /* CODE V's own order, not normalised */
    RMAP_SEQ_FRINGE,
    RMAP_SEQ_QCON,
    RMAP_SEQ_QBFS,
    RMAP_SEQ_FORMS
};

/* What is read of a surface until it is complete. */
struct rmap_seq_shape {
    enum rmap_seq_form form;
    double curvature_x, conic_x;
    double anamorphic[2][4]; /* AR BR CR DR; AP BP CP DP */
    double norm;
};

/* A command of a surface: AAS, CYL, YTO, XTO, SPS, SCO, CUX, RDX, KX, AR ... False: another one.
 * What it does not understand it tells. */
bool rmap_seq_shape_command(struct rmap_prescription *lens, size_t line,
                            struct rmap_lens_surface *surface, struct rmap_seq_shape *shape,
                            const char *key, char *const *word, size_t n);

/* Fills the surface when it is complete. *turned: its x is the profile's y. */
void rmap_seq_shape_end(struct rmap_lens_surface *surface, const struct rmap_seq_shape *shape,
                        bool *turned);

#endif
