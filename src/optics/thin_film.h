/* SPDX-License-Identifier: MIT
 *
 * Stacks of thin films between two media, by Fresnel's amplitudes and the phases between them (Born
 * & Wolf, Principles of Optics, 7th ed., 1.6 and 14.4; Macleod, Thin-Film Optical Filters). Indices
 * are n + i k, k >= 0 where light is absorbed.
 */
#ifndef RMAP_THIN_FILM_H
#define RMAP_THIN_FILM_H

#include <stdbool.h>
#include <stddef.h>

/* At one wavelength; the thickness in wavelengths of vacuum. */
struct rmap_thin_film_layer {
    double n, k, thickness;
};

/* Shares of the power that arrives, for light polarised across the plane of incidence and in it;
 * what is left of 1 is absorbed. */
struct rmap_thin_film_shares {
    double rs, rp, ts, tp;
    bool total; /* the media allow no refraction, whatever the films are */
};

/* From a medium of index n1 into one of index n2 + i k2, cos_i in [0, 1]. layer: [n_layer] in the
 * order in which light meets them, or, backwards, the other way round. No layers: the boundary. */
struct rmap_thin_film_shares rmap_thin_film_shares(const struct rmap_thin_film_layer *layer,
                                                   size_t n_layer, bool backwards, double n1,
                                                   double n2, double k2, double cos_i);

#endif
