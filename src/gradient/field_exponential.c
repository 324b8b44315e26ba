/* SPDX-License-Identifier: MIT
 *
 * Exponential atmospheres, flat or round; with a negative refractivity the hot layer over a road.
 */
#include "gradient/field_internal.h"

/* f, df/dh, d2f/dh2; parameter: {n_far, refractivity, scale_height, radius} */
static void fall(const double *parameter, double h, double f[3])
{
    /* Far below the ground, where no light comes, it stays a number: a body may reach there. */
    double part = parameter[1] * exp(fmin(-h / parameter[2], 300.0));
    f[0] = parameter[0] + part;
    f[1] = -part / parameter[2];
    f[2] = -f[1] / parameter[2];
}

static bool jet_flat(const double *parameter, int n_parameter, double s, double jet[3])
{
    (void)n_parameter;
    fall(parameter, s, jet);
    return true;
}

/* Heights are differences of r: at r = 6.4e6 m they hold 1e-9 m, so n - 1 its 13 digits. */
static bool jet_round(const double *parameter, int n_parameter, double s, double jet[3])
{
    (void)n_parameter;
    if (!(s > 0.0))
        return false;
    double f[3], r = sqrt(s);
    fall(parameter, r - parameter[3], f);
    rmap_jet_of_radius(r, f, jet);
    return true;
}

#define EXPONENTIAL(s_of, jet_of)                                                                  \
    {                                                                                              \
        .model = "exponential", .s = (s_of), .q = RMAP_SERIES_OF_N, .jet = (jet_of),               \
        .may_be_missing = true, .n_parameter = 4, .parameter = {                                   \
            {"n_far", RMAP_NEED_POSITIVE},                                                         \
            {"refractivity", RMAP_NEED_FINITE},                                                    \
            {"scale_height", RMAP_NEED_NOT_ZERO},                                                  \
            {"radius", RMAP_NEED_NOT_NEGATIVE}                                                     \
        }                                                                                          \
    }

static const struct rmap_jet_model flat = EXPONENTIAL(RMAP_SERIES_Z, jet_flat);
static const struct rmap_jet_model round_one = EXPONENTIAL(RMAP_SERIES_R2, jet_round);

enum rmap_status rmap_field_exponential(struct rmap_field **field_ret, int n_channel,
                                        const struct rmap_exponential *parameter,
                                        struct rmap_error *err)
{
    for (int c = 1; c < n_channel; c++)
        if (parameter[c].radius != parameter[0].radius)
            return rmap_error_set(err, RMAP_INPUT,
                                  "exponential: radius differs between wavelengths; give one");
    return rmap_field_of_model(field_ret, parameter[0].radius == 0.0 ? &flat : &round_one,
                               n_channel, parameter, err);
}
