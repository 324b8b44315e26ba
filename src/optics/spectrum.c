/* SPDX-License-Identifier: MIT
 *
 * Spectra on a scene's channels. In spectral mode a channel stands for the band of wavelengths
 * nearer to it than to its neighbours; continuous spectra are weighted with the bands' widths.
 */
#include "optics/spectrum.h"

#include <math.h>
#include <stdbool.h>

#define LUMEN_PER_WATT 683.0

/* Luminance of the linear sRGB components: y of the primaries of IEC 61966-2-1. */
static const double rgb_luminance[3] = {0.2126390058715104, 0.7151686787677559, 0.0721923153607337};

/* Where the bands of red, green and blue begin and end. */
static const double rgb_band_nm[3][2] = {{580.0, 700.0}, {490.0, 580.0}, {400.0, 490.0}};

double rmap_table1_at(const struct rmap_table1 *table, double wavelength_nm)
{
    if (table->n == 0)
        return 0.0;
    const double *x = table->wavelength_nm;
    if (wavelength_nm <= x[0])
        return table->value[0];
    if (wavelength_nm >= x[table->n - 1])
        return table->value[table->n - 1];
    size_t low = 0, high = table->n - 1; /* x[low] <= wavelength < x[high] */
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if (x[middle] <= wavelength_nm)
            low = middle;
        else
            high = middle;
    }
    double fraction = (wavelength_nm - x[low]) / (x[high] - x[low]);
    return table->value[low] + fraction * (table->value[high] - table->value[low]);
}

/* Scaled to 1 at 560 nm, so that no temperature over- or underflows in the visible. */
double rmap_blackbody(double temperature_k, double wavelength_nm)
{
    const double c2_nm_k = 1.438776877e7; /* h c / k, exact SI constants */
    const double reference_nm = 560.0;
    double x = c2_nm_k / (wavelength_nm * temperature_k);
    double x0 = c2_nm_k / (reference_nm * temperature_k);
    double ratio = reference_nm / wavelength_nm;
    double ratio5 = ratio * ratio * ratio * ratio * ratio;
    /* expm1(x0) / expm1(x) with both exponentials pulled out of the fraction */
    return ratio5 * exp(x0 - x) * expm1(-x0) / expm1(-x);
}

static int rgb_band_of(double wavelength_nm)
{
    if (wavelength_nm < rgb_band_nm[1][0])
        return 2;
    return wavelength_nm < rgb_band_nm[0][0] ? 1 : 0;
}

/* Power per nm, or reflectance. */
static double density(const struct rmap_spectrum *spectrum, double wavelength_nm)
{
    switch (spectrum->kind) {
    case RMAP_SPECTRUM_EQUAL:
        return spectrum->value;
    case RMAP_SPECTRUM_LINES:
    case RMAP_SPECTRUM_TABLE:
        return rmap_table1_at(&spectrum->table, wavelength_nm);
    case RMAP_SPECTRUM_BLACKBODY:
        return rmap_blackbody(spectrum->temperature_k, wavelength_nm);
    case RMAP_SPECTRUM_D65:
        return rmap_d65(wavelength_nm);
    case RMAP_SPECTRUM_RGB:
        return spectrum->rgb[rgb_band_of(wavelength_nm)];
    }
    return 0.0;
}

/* Width of the band that channel i stands for; the end bands are symmetric about their channel. */
static double band_width(const struct rmap_channels *channels, int i)
{
    const double *x = channels->wavelength_nm;
    int last = channels->n - 1;
    if (last == 0)
        return 1.0;
    double below = i > 0 ? x[i] - x[i - 1] : x[1] - x[0];
    double above = i < last ? x[i + 1] - x[i] : x[last] - x[last - 1];
    return 0.5 * (below + above);
}

static int nearest_channel(const struct rmap_channels *channels, double wavelength_nm)
{
    int best = 0;
    for (int i = 1; i < channels->n; i++)
        if (fabs(channels->wavelength_nm[i] - wavelength_nm) <
            fabs(channels->wavelength_nm[best] - wavelength_nm))
            best = i;
    return best;
}

static void watts_spectral(const struct rmap_spectrum *spectrum,
                           const struct rmap_channels *channels, double *watt)
{
    for (int i = 0; i < channels->n; i++) {
        if (spectrum->kind == RMAP_SPECTRUM_LINES)
            watt[i] = 0.0;
        else if (spectrum->kind == RMAP_SPECTRUM_EQUAL)
            watt[i] = 1.0;
        else
            watt[i] = density(spectrum, channels->wavelength_nm[i]) * band_width(channels, i);
    }
    if (spectrum->kind != RMAP_SPECTRUM_LINES)
        return;
    for (size_t k = 0; k < spectrum->table.n; k++)
        watt[nearest_channel(channels, spectrum->table.wavelength_nm[k])] +=
            spectrum->table.value[k];
}

static void add_xyz(double wavelength_nm, double power, double xyz[3])
{
    double bar[3];
    rmap_cie1931(wavelength_nm, bar);
    for (int i = 0; i < 3; i++)
        xyz[i] += power * bar[i];
}

static void watts_rgb(const struct rmap_spectrum *spectrum, double rgb[3])
{
    if (spectrum->kind == RMAP_SPECTRUM_EQUAL || spectrum->kind == RMAP_SPECTRUM_RGB) {
        for (int i = 0; i < 3; i++)
            rgb[i] = spectrum->kind == RMAP_SPECTRUM_RGB ? spectrum->rgb[i] : 1.0;
        return;
    }
    double xyz[3] = {0.0, 0.0, 0.0};
    if (spectrum->kind == RMAP_SPECTRUM_LINES) {
        for (size_t k = 0; k < spectrum->table.n; k++)
            add_xyz(spectrum->table.wavelength_nm[k], spectrum->table.value[k], xyz);
    } else {
        for (int nm = 360; nm <= 830; nm++)
            add_xyz((double)nm, density(spectrum, (double)nm), xyz);
    }
    rmap_xyz_to_rgb(xyz, rgb);
}

/* Lumens per watt of channel i, without the factor 683. */
static double channel_luminance(const struct rmap_channels *channels, int i)
{
    if (channels->mode == RMAP_COLOUR_RGB)
        return rgb_luminance[i];
    return rmap_luminous_efficiency(channels->wavelength_nm[i]);
}

enum rmap_status rmap_spectrum_shares(const struct rmap_spectrum *spectrum,
                                      const struct rmap_channels *channels, int luminous,
                                      double *share, struct rmap_error *err)
{
    if (channels->mode == RMAP_COLOUR_RGB)
        watts_rgb(spectrum, share);
    else
        watts_spectral(spectrum, channels, share);
    double total = 0.0;
    for (int i = 0; i < channels->n; i++) {
        if (luminous)
            share[i] *= channel_luminance(channels, i);
        if (!(share[i] > 0.0))
            share[i] = 0.0;
        total += share[i];
    }
    if (!(total > 0.0) || !isfinite(total))
        return rmap_error_set(err, RMAP_INPUT, "the spectrum has no %s on the scene's channels",
                              luminous ? "visible light" : "power");
    for (int i = 0; i < channels->n; i++)
        share[i] /= total;
    return RMAP_OK;
}

void rmap_spectrum_sample(const struct rmap_spectrum *spectrum,
                          const struct rmap_channels *channels, double *value)
{
    for (int i = 0; i < channels->n; i++) {
        if (channels->mode == RMAP_COLOUR_SPECTRAL || spectrum->kind == RMAP_SPECTRUM_EQUAL)
            value[i] = density(spectrum, channels->wavelength_nm[i]);
        else if (spectrum->kind == RMAP_SPECTRUM_RGB)
            value[i] = spectrum->rgb[i];
        else {
            /* mean over the band from the middles of its nanometres */
            double sum = 0.0, width = rgb_band_nm[i][1] - rgb_band_nm[i][0];
            for (int k = 0; k < (int)width; k++)
                sum += density(spectrum, rgb_band_nm[i][0] + (double)k + 0.5);
            value[i] = sum / width;
        }
    }
}

double rmap_luminous_efficacy(const struct rmap_channels *channels, const double *watt_share)
{
    double sum = 0.0;
    for (int i = 0; i < channels->n; i++)
        sum += watt_share[i] * channel_luminance(channels, i);
    return LUMEN_PER_WATT * sum;
}

/* Brings the largest component to 1; false for no light. */
static bool normalise_rgb(double rgb[3])
{
    double largest = fmax(rgb[0], fmax(rgb[1], rgb[2]));
    if (!(largest > 0.0))
        return false;
    for (int i = 0; i < 3; i++)
        rgb[i] = fmax(0.0, rgb[i]) / largest;
    return true;
}

double rmap_rgb_luminance(const double rgb[3])
{
    return rgb_luminance[0] * rgb[0] + rgb_luminance[1] * rgb[1] + rgb_luminance[2] * rgb[2];
}

void rmap_channel_colours(const struct rmap_channels *channels, int luminous, double (*colour)[3])
{
    for (int i = 0; i < channels->n; i++) {
        if (channels->mode == RMAP_COLOUR_SPECTRAL)
            rmap_cie1931(channels->wavelength_nm[i], colour[i]);
        for (int k = 0; k < 3 && channels->mode == RMAP_COLOUR_RGB; k++)
            colour[i][k] = k == i;
        double y = channel_luminance(channels, i);
        for (int k = 0; k < 3 && luminous; k++)
            colour[i][k] = y > 0.0 ? colour[i][k] / y : 0.0;
    }
}

void rmap_colour_display(const struct rmap_channels *channels, const double *share, int luminous,
                         double rgb[3])
{
    double sum[3] = {0.0, 0.0, 0.0}, total = 0.0;
    for (int i = 0; i < channels->n; i++) {
        double luminance = channel_luminance(channels, i), watt = share[i];
        if (luminous)
            watt = luminance > 0.0 ? watt / luminance : 0.0;
        total += share[i];
        if (channels->mode == RMAP_COLOUR_RGB)
            sum[i] = watt;
        else
            add_xyz(channels->wavelength_nm[i], watt, sum);
    }
    if (channels->mode == RMAP_COLOUR_SPECTRAL)
        rmap_xyz_to_rgb(sum, rgb);
    else
        for (int i = 0; i < 3; i++)
            rgb[i] = sum[i];
    if (!normalise_rgb(rgb))
        for (int i = 0; i < 3; i++)
            rgb[i] = total > 0.0 ? 0.5 : 0.0;
}
