/* SPDX-License-Identifier: MIT
 *
 * Refractive index and internal absorption of a material over wavelength.
 */
#include "optics/glass.h"

#include <math.h>

#include "base/vec.h"
#include "optics/spectrum.h"

/* Exponents of all materials are whole: by multiplication every machine gets the same bits. */
static double power(double base, double exponent)
{
    double product = 1.0;
    for (int i = 0; i < (int)fabs(exponent); i++)
        product *= base;
    return exponent < 0.0 ? 1.0 / product : product;
}

static double sellmeier(const struct rmap_glass *glass, double l2)
{
    const double *c = glass->coefficient;
    double n2 = 1.0 + c[0];
    for (size_t i = 1; i + 1 < glass->n_coefficient; i += 2) {
        double gap = l2 - (glass->formula == 1 ? c[i + 1] * c[i + 1] : c[i + 1]);
        if (gap == 0.0)
            return (double)NAN;
        n2 += c[i] * l2 / gap;
    }
    return n2 >= 1.0 ? n2 : (double)NAN;
}

static double polynomial(const struct rmap_glass *glass, size_t first, double l)
{
    const double *c = glass->coefficient;
    double sum = c[0];
    for (size_t i = first; i + 1 < glass->n_coefficient; i += 2)
        sum += c[i] * power(l, c[i + 1]);
    return sum;
}

static double general(const struct rmap_glass *glass, double l)
{
    enum { POLES = 2, PER_POLE = 4 };
    double n2 = polynomial(glass, 1 + POLES * PER_POLE, l);
    for (size_t i = 0; i < POLES; i++) {
        const double *c = &glass->coefficient[1 + i * PER_POLE];
        n2 += c[0] * power(l, c[1]) / (l * l - power(c[2], c[3]));
    }
    return n2;
}

/* Tables of transparent materials are smooth but coarse in the infrared: of LZOS's, the cubic
 * through four rows gives a row left out to 5e-6 (median), a straight line to 6e-5. */
static double cubic(const struct rmap_glass_table *table, double nm)
{
    enum { POINTS = 4 };
    const double *x = table->wavelength_nm;
    size_t first = 0;
    while (first + POINTS < table->n && x[first + POINTS / 2] < nm)
        first++;
    double sum = 0.0;
    for (size_t i = first; i < first + POINTS; i++) {
        double share = table->value[i];
        for (size_t k = first; k < first + POINTS; k++)
            if (k != i)
                share *= (nm - x[k]) / (x[i] - x[k]);
        sum += share;
    }
    return sum;
}

static double at(const struct rmap_glass_table *table, double nm)
{
    return rmap_table1_at(&(struct rmap_table1){table->n, table->wavelength_nm, table->value}, nm);
}

static double table_index(const struct rmap_glass *glass, double nm)
{
    const struct rmap_glass_table *table = &glass->index;
    enum { FEWEST = 4 };
    const bool inside =
        nm > table->wavelength_nm[0] && nm < table->wavelength_nm[table->n ? table->n - 1 : 0];
    return inside && !glass->linear && table->n >= FEWEST ? cubic(table, nm) : at(table, nm);
}

double rmap_glass_index(const struct rmap_glass *glass, double wavelength_nm)
{
    const double l = wavelength_nm * 1e-3, l2 = wavelength_nm * wavelength_nm * 1e-6;
    double n2 = (double)NAN;
    switch (glass->formula) {
    case 1:
    case 2:
        n2 = sellmeier(glass, l2);
        break;
    case 3:
        n2 = polynomial(glass, 1, l);
        break;
    case 4:
        n2 = general(glass, l);
        break;
    case 5:
        return polynomial(glass, 1, l);
    default:
        return table_index(glass, wavelength_nm);
    }
    return n2 > 0.0 && isfinite(n2) ? sqrt(n2) : (double)NAN;
}

/* L times the derivatives of the above. */

static double sellmeier_slope(const struct rmap_glass *glass, double l2)
{
    const double *c = glass->coefficient;
    double slope = 0.0;
    for (size_t i = 1; i + 1 < glass->n_coefficient; i += 2) {
        const double pole = glass->formula == 1 ? c[i + 1] * c[i + 1] : c[i + 1], gap = l2 - pole;
        slope -= 2.0 * c[i] * l2 * pole / (gap * gap);
    }
    return slope;
}

static double polynomial_slope(const struct rmap_glass *glass, size_t first, double l)
{
    const double *c = glass->coefficient;
    double sum = 0.0;
    for (size_t i = first; i + 1 < glass->n_coefficient; i += 2)
        sum += c[i] * c[i + 1] * power(l, c[i + 1]);
    return sum;
}

static double general_slope(const struct rmap_glass *glass, double l)
{
    enum { POLES = 2, PER_POLE = 4 };
    double slope = polynomial_slope(glass, 1 + POLES * PER_POLE, l);
    for (size_t i = 0; i < POLES; i++) {
        const double *c = &glass->coefficient[1 + i * PER_POLE];
        const double gap = l * l - power(c[2], c[3]);
        slope += c[0] * power(l, c[1]) * (c[1] - 2.0 * l * l / gap) / gap;
    }
    return slope;
}

double rmap_glass_group_index(const struct rmap_glass *glass, double wavelength_nm)
{
    const double l = wavelength_nm * 1e-3, n = rmap_glass_index(glass, wavelength_nm);
    const struct rmap_glass_table *table = &glass->index;
    switch (glass->formula) {
    case 1:
    case 2:
        return n - sellmeier_slope(glass, l * l) / (2.0 * n);
    case 3:
        return n - polynomial_slope(glass, 1, l) / (2.0 * n);
    case 4:
        return n - general_slope(glass, l) / (2.0 * n);
    case 5:
        return n - polynomial_slope(glass, 1, l);
    default:
        return n - wavelength_nm *
                       rmap_table1_slope(
                           &(struct rmap_table1){table->n, table->wavelength_nm, table->value},
                           wavelength_nm);
    }
}

double rmap_glass_extinction(const struct rmap_glass *glass, double wavelength_nm)
{
    return at(&glass->extinction, wavelength_nm);
}

double rmap_glass_transmittance(const struct rmap_glass *glass, double wavelength_nm,
                                double path_mm)
{
    const struct rmap_glass_table *k = &glass->extinction;
    if (k->n == 0 || wavelength_nm < k->wavelength_nm[0] ||
        wavelength_nm > k->wavelength_nm[k->n - 1])
        return (double)NAN;
    return exp(-4.0 * RMAP_PI * at(k, wavelength_nm) * path_mm * 1e6 / wavelength_nm);
}

double rmap_glass_abbe(const struct rmap_glass *glass)
{
    if (glass->from_nm > RMAP_LINE_F_NM || glass->to_nm < RMAP_LINE_C_NM)
        return (double)NAN;
    return (rmap_glass_index(glass, RMAP_LINE_D_NM) - 1.0) /
           (rmap_glass_index(glass, RMAP_LINE_F_NM) - rmap_glass_index(glass, RMAP_LINE_C_NM));
}
