/* SPDX-License-Identifier: MIT
 *
 * Spectra on a scene's channels. In spectral mode a channel stands for the band of wavelengths
 * nearer to it than to its neighbours; continuous spectra are weighted with the bands' widths.
 */
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "base/search.h"
#include "optics/spectrum.h"

/* Tables of the CIE: colour matching functions of the 1931 standard observer (ISO/CIE 11664-1,
 * 5 nm abridgement; their y is V(lambda) of 1924) and standard illuminant D65 (ISO/CIE 11664-2). */

#define STEP_NM 5.0

/* clang-format off */
#define CMF_FROM_NM 360.0
#define CMF_N       95
static const double cmf[CMF_N][3] = {
    {0.0001299, 3.917e-06, 0.0006061},
    {0.0002321, 6.965e-06, 0.001086},
    {0.0004149, 1.239e-05, 0.001946},
    {0.0007416, 2.202e-05, 0.003486},
    {0.001368, 3.9e-05, 0.006450001},
    {0.002236, 6.4e-05, 0.01054999},
    {0.004243, 0.00012, 0.02005001},
    {0.00765, 0.000217, 0.03621},
    {0.01431, 0.000396, 0.06785001},
    {0.02319, 0.00064, 0.1102},
    {0.04351, 0.00121, 0.2074},
    {0.07763, 0.00218, 0.3713},
    {0.13438, 0.004, 0.6456},
    {0.21477, 0.0073, 1.0390501},
    {0.2839, 0.0116, 1.3856},
    {0.3285, 0.01684, 1.62296},
    {0.34828, 0.023, 1.74706},
    {0.34806, 0.0298, 1.7826},
    {0.3362, 0.038, 1.77211},
    {0.3187, 0.048, 1.7441},
    {0.2908, 0.06, 1.6692},
    {0.2511, 0.0739, 1.5281},
    {0.19536, 0.09098, 1.28764},
    {0.1421, 0.1126, 1.0419},
    {0.09564, 0.13902, 0.8129501},
    {0.05795001, 0.1693, 0.6162},
    {0.03201, 0.20802, 0.46518},
    {0.0147, 0.2586, 0.3533},
    {0.0049, 0.323, 0.272},
    {0.0024, 0.4073, 0.2123},
    {0.0093, 0.503, 0.1582},
    {0.0291, 0.6082, 0.1117},
    {0.06327, 0.71, 0.07824999},
    {0.1096, 0.7932, 0.05725001},
    {0.1655, 0.862, 0.04216},
    {0.2257499, 0.9148501, 0.02984},
    {0.2904, 0.954, 0.0203},
    {0.3597, 0.9803, 0.0134},
    {0.4334499, 0.9949501, 0.008749999},
    {0.5120501, 1, 0.005749999},
    {0.5945, 0.995, 0.0039},
    {0.6784, 0.9786, 0.002749999},
    {0.7621, 0.952, 0.0021},
    {0.8425, 0.9154, 0.0018},
    {0.9163, 0.87, 0.001650001},
    {0.9786, 0.8163, 0.0014},
    {1.0263, 0.757, 0.0011},
    {1.0567, 0.6949, 0.001},
    {1.0622, 0.631, 0.0008},
    {1.0456, 0.5668, 0.0006},
    {1.0026, 0.503, 0.00034},
    {0.9384, 0.4412, 0.00024},
    {0.8544499, 0.381, 0.00019},
    {0.7514, 0.321, 0.0001},
    {0.6424, 0.265, 4.999999e-05},
    {0.5419, 0.217, 3e-05},
    {0.4479, 0.175, 2e-05},
    {0.3608, 0.1382, 1e-05},
    {0.2835, 0.107, 0},
    {0.2187, 0.0816, 0},
    {0.1649, 0.061, 0},
    {0.1212, 0.04458, 0},
    {0.0874, 0.032, 0},
    {0.0636, 0.0232, 0},
    {0.04677, 0.017, 0},
    {0.0329, 0.01192, 0},
    {0.0227, 0.00821, 0},
    {0.01584, 0.005723, 0},
    {0.01135916, 0.004102, 0},
    {0.008110916, 0.002929, 0},
    {0.005790346, 0.002091, 0},
    {0.004109457, 0.001484, 0},
    {0.002899327, 0.001047, 0},
    {0.00204919, 0.00074, 0},
    {0.001439971, 0.00052, 0},
    {0.0009999493, 0.0003611, 0},
    {0.0006900786, 0.0002492, 0},
    {0.0004760213, 0.0001719, 0},
    {0.0003323011, 0.00012, 0},
    {0.0002348261, 8.48e-05, 0},
    {0.0001661505, 6e-05, 0},
    {0.000117413, 4.24e-05, 0},
    {8.307527e-05, 3e-05, 0},
    {5.870652e-05, 2.12e-05, 0},
    {4.150994e-05, 1.499e-05, 0},
    {2.935326e-05, 1.06e-05, 0},
    {2.067383e-05, 7.4657e-06, 0},
    {1.455977e-05, 5.2578e-06, 0},
    {1.025398e-05, 3.7029e-06, 0},
    {7.221456e-06, 2.6078e-06, 0},
    {5.085868e-06, 1.8366e-06, 0},
    {3.581652e-06, 1.2934e-06, 0},
    {2.522525e-06, 9.1093e-07, 0},
    {1.776509e-06, 6.4153e-07, 0},
    {1.251141e-06, 4.5181e-07, 0},
};
#define D65_FROM_NM 300.0
#define D65_N       107
static const double d65[D65_N] = {
    0.0341, 1.6643, 3.2945, 11.7652, 20.236, 28.6447, 37.0535, 38.5011, 39.9488, 42.4302,
    44.9117, 45.775, 46.6383, 49.3637, 52.0891, 51.0323, 49.9755, 52.3118, 54.6482, 68.7015,
    82.7549, 87.1204, 91.486, 92.4589, 93.4318, 90.057, 86.6823, 95.7736, 104.865, 110.936,
    117.008, 117.41, 117.812, 116.336, 114.861, 115.392, 115.923, 112.367, 108.811, 109.082,
    109.354, 108.578, 107.802, 106.296, 104.79, 106.239, 107.689, 106.047, 104.405, 104.225,
    104.046, 102.023, 100.0, 98.1671, 96.3342, 96.0611, 95.788, 92.2368, 88.6856, 89.3459, 90.0062,
    89.8026, 89.5991, 88.6489, 87.6987, 85.4936, 83.2886, 83.4939, 83.6992, 81.863, 80.0268,
    80.1207, 80.2146, 81.2462, 82.2778, 80.281, 78.2842, 74.0027, 69.7213, 70.6652, 71.6091,
    72.979, 74.349, 67.9765, 61.604, 65.7448, 69.8856, 72.4863, 75.087, 69.3398, 63.5927, 55.0054,
    46.4182, 56.6118, 66.8054, 65.0941, 63.3828, 63.8434, 64.304, 61.8779, 59.4519, 55.7054,
    51.959, 54.6998, 57.4406, 58.8765, 60.3125};
/* clang-format on */

/* Row below a wavelength and how far on to the next, in [0, 1]; -1 outside the table. */
static int locate(double wavelength_nm, double from_nm, int n, double *fraction)
{
    double place = (wavelength_nm - from_nm) / STEP_NM;
    if (!(place >= 0.0 && place <= (double)(n - 1)))
        return -1;
    int row = (int)place;
    if (row == n - 1)
        row--;
    *fraction = place - (double)row;
    return row;
}

double rmap_d65(double wavelength_nm)
{
    double fraction = 0.0;
    int row = locate(wavelength_nm, D65_FROM_NM, D65_N, &fraction);
    return row < 0 ? 0.0 : d65[row] + fraction * (d65[row + 1] - d65[row]);
}

void rmap_cie1931(double wavelength_nm, double xyz[3])
{
    double fraction = 0.0;
    int row = locate(wavelength_nm, CMF_FROM_NM, CMF_N, &fraction);
    for (int i = 0; i < 3; i++)
        xyz[i] = row < 0 ? 0.0 : cmf[row][i] + fraction * (cmf[row + 1][i] - cmf[row][i]);
}

double rmap_luminous_efficiency(double wavelength_nm)
{
    double xyz[3];
    rmap_cie1931(wavelength_nm, xyz);
    return xyz[1];
}

/* Inverse of the matrix of IEC 61966-2-1's primaries and white point, to the digits that its
 * chromaticities (R 0.64 0.33, G 0.30 0.60, B 0.15 0.06, W 0.3127 0.3290) determine. */
void rmap_xyz_to_rgb(const double xyz[3], double rgb[3])
{
    static const double matrix[3][3] = {
        {3.2409699419045213, -1.5373831775700935, -0.4986107602930033},
        {-0.9692436362808798, 1.8759675015077206, 0.0415550574071757},
        {0.0556300796969936, -0.2039769588889766, 1.0569715142428786}};
    for (int i = 0; i < 3; i++)
        rgb[i] = matrix[i][0] * xyz[0] + matrix[i][1] * xyz[1] + matrix[i][2] * xyz[2];
}

void rmap_rgb_to_xyz(const double rgb[3], double xyz[3])
{
    static const double matrix[3][3] = {
        {0.41239079926595934, 0.35758433938387796, 0.1804807884018343},
        {0.21263900587151027, 0.7151686787677559, 0.07219231536073371},
        {0.01933081871559182, 0.11919477979462598, 0.9505321522496607}};
    for (int i = 0; i < 3; i++)
        xyz[i] = matrix[i][0] * rgb[0] + matrix[i][1] * rgb[1] + matrix[i][2] * rgb[2];
}

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

/* Of a knot of a spline a row so far away moves the derivative by 1e-13 of itself. */
enum { SPLINE_REACH = 24 };

/* Second derivatives at the m knots of a spline, m > 3, by elimination (de Boor 1978, A Practical
 * Guide to Splines, IV). */
static void bend_spline(const double *x, const double *y, size_t m, double *bend)
{
    double diagonal[2 * SPLINE_REACH], upper[2 * SPLINE_REACH], right[2 * SPLINE_REACH];
    for (size_t i = 1; i + 1 < m; i++) {
        const double h = x[i] - x[i - 1], next = x[i + 1] - x[i];
        double lower = h;
        diagonal[i] = 2.0 * (h + next);
        upper[i] = next;
        right[i] = 6.0 * ((y[i + 1] - y[i]) / next - (y[i] - y[i - 1]) / h);
        if (i == 1) { /* the third derivative goes on through the second knot, */
            diagonal[i] += h + h * h / next;
            upper[i] -= h * h / next;
        }
        if (i + 2 == m) { /* and through the last but one */
            diagonal[i] += next + next * next / h;
            lower -= next * next / h;
        }
        if (i > 1) {
            const double share = lower / diagonal[i - 1];
            diagonal[i] -= share * upper[i - 1];
            right[i] -= share * right[i - 1];
        }
    }
    for (size_t i = m - 2; i > 0; i--)
        bend[i] = (right[i] - (i + 2 < m ? upper[i] * bend[i + 1] : 0.0)) / diagonal[i];
    bend[0] = bend[1] - (x[1] - x[0]) / (x[2] - x[1]) * (bend[2] - bend[1]);
    bend[m - 1] =
        bend[m - 2] + (x[m - 1] - x[m - 2]) / (x[m - 2] - x[m - 3]) * (bend[m - 2] - bend[m - 3]);
}

double rmap_table1_slope(const struct rmap_table1 *table, double wavelength_nm)
{
    const double nm = wavelength_nm, *row = table->wavelength_nm;
    const size_t n = table->n;
    double x[2 * SPLINE_REACH], y[2 * SPLINE_REACH], bend[2 * SPLINE_REACH] = {0};
    if (n < 2 || !(nm >= row[0] && nm <= row[n - 1]))
        return 0.0;
    size_t at = 0;
    while (at + 2 < n && row[at + 1] < nm)
        at++;
    const size_t first = at + 1 > SPLINE_REACH ? at + 1 - SPLINE_REACH : 0;
    const size_t m = n - first < 2 * SPLINE_REACH ? n - first : 2 * SPLINE_REACH;
    for (size_t i = 0; i < m; i++) {
        const size_t from = first + m - 1 - i;
        x[i] = 1.0 / (row[from] * row[from]);
        y[i] = table->value[from];
    }
    if (m > 3)
        bend_spline(x, y, m, bend);
    else if (m == 3)
        bend[0] = bend[1] = bend[2] =
            2.0 * ((y[2] - y[1]) / (x[2] - x[1]) - (y[1] - y[0]) / (x[1] - x[0])) / (x[2] - x[0]);
    const size_t k = first + m - 2 - at;
    const double h = x[k + 1] - x[k], t = 1.0 / (nm * nm) - x[k];
    const double slope = (y[k + 1] - y[k]) / h - h / 6.0 * (2.0 * bend[k] + bend[k + 1]) +
                         t * bend[k] + t * t * (bend[k + 1] - bend[k]) / (2.0 * h);
    return -2.0 * slope / (nm * nm * nm);
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

void rmap_channel_steps(const struct rmap_channels *channels, int i, double *below, double *above)
{
    const double *x = channels->wavelength_nm;
    const int last = channels->n - 1;
    *below = *above = 1.0;
    if (last == 0)
        return;
    *below = i > 0 ? x[i] - x[i - 1] : x[1] - x[0];
    *above = i < last ? x[i + 1] - x[i] : x[last] - x[last - 1];
}

void rmap_channel_band(const struct rmap_channels *channels, int i, double band_nm[2])
{
    double below, above;
    if (channels->mode == RMAP_COLOUR_RGB) {
        memcpy(band_nm, rgb_band_nm[i], sizeof rgb_band_nm[i]);
        return;
    }
    rmap_channel_steps(channels, i, &below, &above);
    band_nm[0] = channels->wavelength_nm[i] - 0.5 * below;
    band_nm[1] = channels->wavelength_nm[i] + 0.5 * above;
}

struct rmap_channels rmap_channels_of_coats(const struct rmap_channels *channels)
{
    struct rmap_channels at = *channels;
    for (int i = 0; i < at.n && at.mode == RMAP_COLOUR_RGB && at.coats_by_band; i++) {
        double band[2];
        rmap_channel_band(channels, i, band);
        at.wavelength_nm[i] = 0.5 * (band[0] + band[1]);
    }
    return at;
}

static double band_width(const struct rmap_channels *channels, int i)
{
    double below, above;
    rmap_channel_steps(channels, i, &below, &above);
    return 0.5 * (below + above);
}

int rmap_channel_nearest(const struct rmap_channels *channels, double wavelength_nm)
{
    const double *at = channels->wavelength_nm;
    const int i = (int)rmap_first_above(at, (size_t)channels->n, wavelength_nm);
    return i > 0 && wavelength_nm - at[i - 1] <= at[i] - wavelength_nm ? i - 1 : i;
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
        watt[rmap_channel_nearest(channels, spectrum->table.wavelength_nm[k])] +=
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
    return RMAP_LUMENS_PER_WATT * sum;
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

void rmap_channel_bend(const struct rmap_channels *channels, int i, int luminous, double bend[3])
{
    double below = 0.0, above = 0.0, low[3], high[3];
    const double nm = channels->wavelength_nm[i];
    if (channels->mode == RMAP_COLOUR_SPECTRAL && channels->n > 1)
        rmap_channel_steps(channels, i, &below, &above);
    const bool fine = below < STEP_NM * (1.0 + 1e-9) && fabs(above - below) < 1e-9 * nm;
    rmap_cie1931(nm, bend);
    rmap_cie1931(nm - STEP_NM, low);
    rmap_cie1931(nm + STEP_NM, high);
    const double of = !luminous ? 1.0 : bend[1] > 0.0 ? bend[1] : HUGE_VAL;
    const double part = fine ? below * below / (12.0 * STEP_NM * STEP_NM * of) : 0.0;
    for (int k = 0; k < 3; k++)
        bend[k] = part * (low[k] - 2.0 * bend[k] + high[k]);
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
