/* SPDX-License-Identifier: MIT
 *
 * The materials of a prescription: of the program's catalogue, of catalogue files, or models of an
 * index and an Abbe number. All are relative to air.
 */
#ifndef RMAP_LENS_MEDIA_H
#define RMAP_LENS_MEDIA_H

#include "io/lensfile/prescription.h"
#include "optics/glass.h"

enum rmap_lens_medium_kind {
    RMAP_LENS_AIR,
    RMAP_LENS_CATALOGUE, /* by its name there */
    RMAP_LENS_AGF,
    RMAP_LENS_MODEL,
    RMAP_LENS_GRADIENT
};

struct rmap_lens_medium {
    char word[64]; /* as the file has it */
    char name[64]; /* in the scene */
    enum rmap_lens_medium_kind kind;
    const struct rmap_agf_glass *agf;
    const struct rmap_lens_surface *gradient; /* that begins it */
    double nd, vd;                            /* of a model */
    struct rmap_glass glass;
    double index; /* at the primary wavelength */
};

struct rmap_lens_media {
    struct rmap_lens_medium *medium; /* [n]; the first is air */
    size_t n, cap;
    size_t *behind; /* [n_surface]: medium behind each surface of the prescription */
};

/* RMAP_SYSTEM. What is not found is told in the prescription's findings, and something near it
 * stands in its place. */
enum rmap_status rmap_lens_media_make(struct rmap_prescription *lens, struct rmap_lens_media *media,
                                      struct rmap_error *err) RMAP_MUST_USE;
void rmap_lens_media_fini(struct rmap_lens_media *media);

/* Sellmeier's formula with a constant and one term, of a glass of this index and Abbe number whose
 * partial dispersion lies on the normal line P_gF = 0.6438 - 0.001682 V_d (SCHOTT, Technical
 * Information TIE-29); where it cannot, of one term. False: no such glass. */
bool rmap_model_glass(double nd, double vd, struct rmap_glass *glass);

/* A catalogue file's formula as one of struct rmap_glass, or a table at these wavelengths. False:
 * it has no index at one of them. */
bool rmap_agf_to_glass(const struct rmap_agf_glass *agf, const double *wavelength_nm, size_t n,
                       struct rmap_glass *glass);

#endif
