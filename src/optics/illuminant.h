/* SPDX-License-Identifier: MIT
 *
 * Illuminants of CIE 015:2018: incandescent light, daylight, fluorescent lamps. Relative power per
 * nm, every 5 nm from 300 to 830 nm; D65 is rmap_d65.
 */
#ifndef RMAP_ILLUMINANT_H
#define RMAP_ILLUMINANT_H

#include "optics/spectrum.h"

enum { RMAP_ILLUMINANT_N = 107, RMAP_ILLUMINANT_FROM_NM = 300, RMAP_ILLUMINANT_STEP_NM = 5 };

enum rmap_illuminant {
    RMAP_ILLUMINANT_A,
    RMAP_ILLUMINANT_D50,
    RMAP_ILLUMINANT_D55,
    RMAP_ILLUMINANT_D75,
    RMAP_ILLUMINANT_F2, /* 380 to 780 nm; a fluorescent lamp, and one of three bands */
    RMAP_ILLUMINANT_F11
};

void rmap_illuminant_named(enum rmap_illuminant illuminant, double power[RMAP_ILLUMINANT_N]);

/* A phase of daylight; kelvin: its correlated colour temperature, 4000 to 25000. */
void rmap_illuminant_daylight(double kelvin, double power[RMAP_ILLUMINANT_N]);

/* Over the band of each channel, so that lines between channels are not lost: mean[channels->n]. */
void rmap_illuminant_means(const double power[RMAP_ILLUMINANT_N],
                           const struct rmap_channels *channels, double *mean);

/* A Gaussian of that width at half its height, whose integral is 1: its means over the bands of
 * channels, or over the steps of an illuminant. */
void rmap_led_means(double peak_nm, double width_nm, const struct rmap_channels *channels,
                    double *mean);
void rmap_led_steps(double peak_nm, double width_nm, double power[RMAP_ILLUMINANT_N]);

#endif
