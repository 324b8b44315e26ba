/* SPDX-License-Identifier: MIT
 *
 * The hyperbolic-secant rod (Fletcher, Murphy & Young 1954, Proc. R. Soc. A 223, 216): meridional
 * light of every height has the same period 2 pi / alpha.
 */
#include "gradient/field_internal.h"

/* With u = (alpha rho)^2 below this the second derivative's difference of two near-equal numbers
 * would lose more than the series 5/12 - 61/120 u + 1385/3360 u^2 leaves out. */
#define SMALL 1e-3

/* parameter: {n0, alpha} */
static bool jet_sech(const double *parameter, int n_parameter, double s, double jet[3])
{
    (void)n_parameter;
    double alpha2 = parameter[1] * parameter[1], u = alpha2 * s, x = sqrt(u);
    double n = parameter[0] / cosh(x), t = tanh(x);
    double ratio = x > 0.0 ? t / x : 1.0;
    jet[0] = n;
    jet[1] = -0.5 * n * alpha2 * ratio;
    double second = u < SMALL
                        ? parameter[0] * (5.0 / 12.0 + u * (-61.0 / 120.0 + u * 1385.0 / 3360.0))
                        : n * (2.0 * t * t - 1.0 + ratio) / (4.0 * u);
    jet[2] = alpha2 * alpha2 * second;
    return true;
}

static const struct rmap_jet_model sech = {
    .model = "sech",
    .s = RMAP_SERIES_RHO2,
    .q = RMAP_SERIES_OF_N,
    .jet = jet_sech,
    .n_parameter = 2,
    .parameter = {{"n0", RMAP_NEED_POSITIVE}, {"alpha", RMAP_NEED_FINITE}}};

enum rmap_status rmap_field_sech(struct rmap_field **field_ret, int n_channel,
                                 const struct rmap_sech *parameter, struct rmap_error *err)
{
    return rmap_field_of_model(field_ret, &sech, n_channel, parameter, err);
}
