/* SPDX-License-Identifier: MIT
 *
 * Spectral quantities and their evaluation on a scene's channels: tables, blackbody, the CIE
 * standard illuminant D65, V(lambda), and colour.
 */
#ifndef RMAP_SPECTRUM_H
#define RMAP_SPECTRUM_H

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

#define RMAP_CHANNEL_MAX     128
#define RMAP_LUMENS_PER_WATT 683.0 /* of 555 nm: K_m */

/* How light is described. A ray's colour is a vector of shares of its flux, one per channel,
 * summing to 1: shares of watts for sources given in W, of lumens for sources given in lm. */
enum rmap_colour_mode { RMAP_COLOUR_SPECTRAL, RMAP_COLOUR_RGB };

struct rmap_channels {
    enum rmap_colour_mode mode;
    int n;                                  /* RGB: 3 */
    double wavelength_nm[RMAP_CHANNEL_MAX]; /* increasing; RGB: all 587.56 */
    bool coats_by_band;                     /* RGB: films and metals at the middles of the bands */
};

/* A table over wavelength, linear in between, constant beyond its ends. Borrowed arrays. */
struct rmap_table1 {
    size_t n;
    const double *wavelength_nm; /* strictly increasing */
    const double *value;
};

/* To the channels beside channel i, half of which is its band; an end's band is symmetric about it,
 * and that of a channel alone 1 nm wide. */
void rmap_channel_steps(const struct rmap_channels *channels, int i, double *below, double *above);

/* Its band, from and to; of red, green, blue in RGB mode. */
void rmap_channel_band(const struct rmap_channels *channels, int i, double band_nm[2]);

/* The channels with the wavelengths that films and metals are asked at, which are in no order. */
struct rmap_channels rmap_channels_of_coats(const struct rmap_channels *channels);

/* Of spectral channels, the one whose wavelength is nearest; of two as near the shorter. */
int rmap_channel_nearest(const struct rmap_channels *channels, double wavelength_nm);

double rmap_table1_at(const struct rmap_table1 *table, double wavelength_nm);

/* Derivative of an index, per nm, by the cubic spline through the rows over 1 / wavelength^2, where
 * indices bend least (not-a-knot ends; of three rows the parabola, of two the line); 0 outside the
 * table. */
double rmap_table1_slope(const struct rmap_table1 *table, double wavelength_nm);

/* Spectral radiance of a blackbody, relative (Planck 1901). temperature_k > 0. */
double rmap_blackbody(double temperature_k, double wavelength_nm);

/* Relative spectral power of CIE standard illuminant D65 (ISO/CIE 11664-2), 300 to 830 nm, 0
 * outside. */
double rmap_d65(double wavelength_nm);

/* CIE 1924 luminous efficiency V(lambda); 0 outside 360 to 830 nm. */
double rmap_luminous_efficiency(double wavelength_nm);

/* CIE 1931 2-degree colour matching functions (their y is V(lambda)). */
void rmap_cie1931(double wavelength_nm, double xyz[3]);

/* Linear sRGB (IEC 61966-2-1 primaries) of XYZ. May be negative outside the gamut. */
void rmap_xyz_to_rgb(const double xyz[3], double rgb[3]);
double rmap_rgb_luminance(const double rgb[3]);           /* the Y of linear sRGB */
void rmap_rgb_to_xyz(const double rgb[3], double xyz[3]); /* its inverse */

/* What a scene may say of a source's spectrum or of a surface's reflectance. */
enum rmap_spectrum_kind {
    RMAP_SPECTRUM_EQUAL,     /* the same on all channels: value */
    RMAP_SPECTRUM_LINES,     /* wavelength -> relative power; each on its nearest channel */
    RMAP_SPECTRUM_TABLE,     /* power or reflectance per nm over wavelength */
    RMAP_SPECTRUM_BLACKBODY, /* temperature_k */
    RMAP_SPECTRUM_D65,
    RMAP_SPECTRUM_RGB /* rgb */
};

struct rmap_spectrum {
    enum rmap_spectrum_kind kind;
    double value, temperature_k;
    double rgb[3];
    struct rmap_table1 table; /* LINES and TABLE */
};

/* Shares of a source's power per channel, summing to 1: of watts, or of lumens when `luminous`
 * (weighted by V). RGB mode: shares of the linear sRGB components, negative ones clipped.
 * RGB in spectral mode: blue below 490 nm, green to 580 nm, red above.
 * RMAP_INPUT when nothing is left (no power on any channel, or no visible light for lm). */
enum rmap_status rmap_spectrum_shares(const struct rmap_spectrum *spectrum,
                                      const struct rmap_channels *channels, int luminous,
                                      double *share, struct rmap_error *err) RMAP_MUST_USE;

/* A reflectance-like quantity per channel. RGB mode from a table: mean over each band of
 * 400-490-580-700 nm; spectral mode from RGB: the band's value. */
void rmap_spectrum_sample(const struct rmap_spectrum *spectrum,
                          const struct rmap_channels *channels, double *value);

/* Lumens per watt of light with these shares of watts: 683 sum c V; 0 in RGB mode's absence of
 * spectra is never asked (RGB mode: 683 x luminance of the linear RGB shares). */
double rmap_luminous_efficacy(const struct rmap_channels *channels, const double *watt_share);

/* Colour of one unit of light on each channel: CIE XYZ per watt (Y = 1 at 555 nm) or, `luminous`,
 * per lumen (Y = 1) in spectral mode, linear RGB in RGB mode. colour: [channels->n]. */
void rmap_channel_colours(const struct rmap_channels *channels, int luminous, double (*colour)[3]);

/* What the colour of channel i has beyond that, where spectra are straight between
 * channels at most 5 nm apart: as the CIE sums them, over 1 nm (CIE 015:2018, 7.1). 0 where they
 * are wider apart, which stand for their wavelengths alone, and in RGB mode. */
void rmap_channel_bend(const struct rmap_channels *channels, int i, int luminous, double bend[3]);

/* Display colour (linear RGB, largest component 1, all 0 for no light) of a colour vector;
 * `luminous`: the shares are of lumens. Wavelengths outside the visible show as grey. */
void rmap_colour_display(const struct rmap_channels *channels, const double *share, int luminous,
                         double rgb[3]);

#endif
