/* SPDX-License-Identifier: MIT
 *
 * Indices of catalogue files and of model glasses, in the catalogue's own formulas.
 */
#include <math.h>

#include "base/count.h"
#include "io/lensfile/lens_media.h"

/* Of the file's formulas (Zemax's numbers, L in um): those that are sums of powers of L, of n^2 or
 * of n, by the powers of their coefficients. */
static const struct {
    int formula, power[RMAP_AGF_COEFFICIENTS];
} powers[] = {
    {1, {0, 2, -2, -4, -6, -8}},               /* Schott */
    {10, {0, 2, -2, -4, -6, -8, -10, -12}},    /* Extended */
    {12, {0, 2, -2, -4, -6, -8, 4, 6}},        /* Extended 2 */
    {13, {0, 2, 4, -2, -4, -6, -8, -10, -12}}, /* Extended 3 */
};

/* Constant, then pairs (B, C) of B L^2 / (L^2 - C), from the coefficients. */
static void sellmeier(const struct rmap_agf_glass *agf, size_t first, size_t n_pair,
                      double constant, struct rmap_glass *glass)
{
    glass->formula = 2;
    glass->n_coefficient = 1 + 2 * n_pair;
    glass->coefficient[0] = constant;
    for (size_t i = 0; i < 2 * n_pair; i++)
        glass->coefficient[1 + i] = agf->coefficient[first + i];
}

/* n^2 = A + B L^m / (L^2 - C) - D L^2 */
static void handbook(const double *c, double m, struct rmap_glass *glass)
{
    const double general[] = {c[0], c[1], m, c[2], 1, 0, 0, 0, 1, -c[3], 2};
    glass->formula = 4;
    glass->n_coefficient = RMAP_COUNT(general);
    for (size_t i = 0; i < RMAP_COUNT(general); i++)
        glass->coefficient[i] = general[i];
}

static double conrady(const double *c, double l)
{
    return c[0] + c[1] / l + c[2] / pow(l, 3.5);
}

static double herzberger(const double *c, double l)
{
    const double pole = 1 / (l * l - 0.028), l2 = l * l;
    return c[0] + pole * (c[1] + pole * c[2]) + l2 * (c[3] + l2 * (c[4] + l2 * c[5]));
}

/* n^2 - 1 = A + B1 L^2 / (L^2 - L1^2) + B2 / (L^2 - L2^2); B2 / (L^2 - C) is
 * (B2 / C) (L^2 / (L^2 - C) - 1). */
static void sellmeier2(const double *c, struct rmap_glass *glass)
{
    const double c1 = c[2] * c[2], c2 = c[4] * c[4], b2 = c2 > 0 ? c[3] / c2 : 0;
    const double two[] = {c[0] - b2, c[1], c1, b2, c2};
    glass->formula = 2;
    glass->n_coefficient = RMAP_COUNT(two);
    for (size_t i = 0; i < RMAP_COUNT(two); i++)
        glass->coefficient[i] = two[i];
}

/* Rows ascend by wavelength, each once. */
static void put_row(struct rmap_glass *glass, double wavelength_nm, double index)
{
    size_t at = glass->index.n;
    glass->formula = 0;
    glass->linear = true;
    for (size_t i = 0; i < at; i++)
        if (glass->index.wavelength_nm[i] == wavelength_nm)
            return;
    if (at >= RMAP_GLASS_ROWS_MAX)
        return;
    for (; at > 0 && glass->index.wavelength_nm[at - 1] > wavelength_nm; at--) {
        glass->index.wavelength_nm[at] = glass->index.wavelength_nm[at - 1];
        glass->index.value[at] = glass->index.value[at - 1];
    }
    glass->index.wavelength_nm[at] = wavelength_nm;
    glass->index.value[at] = index;
    glass->index.n++;
}

static void table(double (*index)(const double *c, double l), const double *c,
                  const double *wavelength_nm, size_t n, struct rmap_glass *glass)
{
    for (size_t i = 0; i < n; i++)
        put_row(glass, wavelength_nm[i], index(c, 1e-3 * wavelength_nm[i]));
}

static void convert(const struct rmap_agf_glass *agf, const double *wavelength_nm, size_t n,
                    struct rmap_glass *glass)
{
    const double *c = agf->coefficient;
    for (size_t i = 0; i < agf->n_row; i++)
        put_row(glass, 1e3 * agf->row_um[i], agf->row_index[i]);
    if (agf->n_row > 0)
        return;
    for (size_t i = 0; i < RMAP_COUNT(powers); i++)
        if (powers[i].formula == agf->formula) {
            glass->formula = 3;
            glass->coefficient[0] = c[0];
            for (size_t k = 1; k < RMAP_AGF_COEFFICIENTS && powers[i].power[k] != 0; k++) {
                glass->coefficient[2 * k - 1] = c[k];
                glass->coefficient[2 * k] = powers[i].power[k];
                glass->n_coefficient = 2 * k + 1;
            }
            return;
        }
    switch (agf->formula) {
    case 2:
        sellmeier(agf, 0, 3, 0, glass);
        break;
    case 3:
        table(herzberger, c, wavelength_nm, n, glass);
        break;
    case 4:
        sellmeier2(c, glass);
        break;
    case 5:
        table(conrady, c, wavelength_nm, n, glass);
        break;
    case 6:
        sellmeier(agf, 0, 4, 0, glass);
        break;
    case 7:
        handbook(c, 0, glass);
        break;
    case 8:
        handbook(c, 2, glass);
        break;
    case 9:
        sellmeier(agf, 1, 2, c[0] - 1, glass);
        break;
    default:
        sellmeier(agf, 0, 5, 0, glass);
        break; /* 11 */
    }
}

bool rmap_agf_to_glass(const struct rmap_agf_glass *agf, const double *wavelength_nm, size_t n,
                       struct rmap_glass *glass)
{
    *glass = (struct rmap_glass){.from_nm = 1e3 * agf->from_um, .to_nm = 1e3 * agf->to_um};
    convert(agf, wavelength_nm, n, glass);
    for (size_t i = 0; i < n; i++) {
        const double index = rmap_glass_index(glass, wavelength_nm[i]);
        if (!(index >= 1 && index < 10))
            return false;
    }
    return true;
}

/* n^2 - 1 of a constant, a term B L^2 / (L^2 - C) for a given C, and that of the infrared which
 * most glasses have, L^2 / (L^2 - 100 um^2): nd fixes the constant, nF - nC fixes B. */
static bool with_pole(double nd, double dispersion, double pole, struct rmap_glass *glass)
{
    const double infrared = 100, d = 1e-6 * RMAP_LINE_D_NM * RMAP_LINE_D_NM;
    const double rest = nd * nd - 1 - d / (d - infrared), term = d / (d - pole);
    const double sellmeier[] = {0, 0, 0, dispersion, pole, 1, infrared};
    glass->formula = 2;
    glass->n_coefficient = RMAP_COUNT(sellmeier);
    for (size_t i = 0; i < RMAP_COUNT(sellmeier); i++)
        glass->coefficient[i] = sellmeier[i];
    double b = 0.5, step = 0.5; /* nF - nC grows with it */
    for (int i = 0; i < 60; i++, step *= 0.5) {
        glass->coefficient[1] = rest - b * term;
        glass->coefficient[3] = b;
        const double now =
            rmap_glass_index(glass, RMAP_LINE_F_NM) - rmap_glass_index(glass, RMAP_LINE_C_NM);
        b += now > dispersion ? -step : step;
    }
    return b > 0;
}

bool rmap_model_glass(double nd, double vd, struct rmap_glass *glass)
{
    const double line_g = 435.8343, from = 350, to = 1100;
    *glass = (struct rmap_glass){.nd = nd, .vd = vd, .from_nm = from, .to_nm = to};
    if (!(nd >= 1 && nd < 5))
        return false;
    if (!(vd > 0)) { /* without dispersion */
        glass->formula = 2;
        glass->n_coefficient = 3;
        glass->coefficient[1] = nd * nd - 1;
        return true;
    }
    const double dispersion = (nd - 1) / vd, wanted = 0.6438 - 0.001682 * vd;
    double low = 1e-3, high = 0.06; /* of the pole, um^2: P_gF grows with it */
    for (int i = 0; i < 60; i++) {
        const double pole = 0.5 * (low + high);
        if (!with_pole(nd, dispersion, pole, glass))
            return false;
        const double part =
            (rmap_glass_index(glass, line_g) - rmap_glass_index(glass, RMAP_LINE_F_NM)) /
            dispersion;
        if (part < wanted)
            low = pole;
        else
            high = pole;
    }
    return isfinite(rmap_glass_index(glass, from)) && isfinite(rmap_glass_index(glass, to));
}
