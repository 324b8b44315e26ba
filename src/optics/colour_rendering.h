/* SPDX-License-Identifier: MIT
 *
 * Colour rendering of CIE 13.3-1995: how samples look under a light, against how they look under
 * daylight or a Planck radiator of its colour temperature.
 */
#ifndef RMAP_COLOUR_RENDERING_H
#define RMAP_COLOUR_RENDERING_H

#include "optics/spectrum.h"

enum { RMAP_CRI_SAMPLES = 14, RMAP_CRI_GENERAL = 8 };

struct rmap_cri {
    double general;                   /* Ra: the mean of the first eight */
    double special[RMAP_CRI_SAMPLES]; /* R1 to R14 */
};

/* Why there is none of light on these channels; NULL: there is. */
const char *rmap_cri_refused(const struct rmap_channels *channels);

/* watt: power on each channel; kelvin: its colour temperature, below 25000. */
void rmap_cri_of(const struct rmap_channels *channels, const double *watt, double kelvin,
                 struct rmap_cri *cri);

#endif
