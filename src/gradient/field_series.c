/* SPDX-License-Identifier: MIT
 *
 * Power series in z, rho^2 or r^2, of n or of n^2, and the models that are one: Luneburg's and
 * Gutman's lenses, the parabolic and the selfoc rod.
 */
#include "base/alloc.h"
#include "gradient/field_internal.h"

/* Horner's rule for a polynomial and its first two derivatives. */
bool rmap_jet_series(const double *parameter, int n_parameter, double s, double jet[3])
{
    double q = parameter[n_parameter - 1], first = 0.0, half_second = 0.0;
    for (int i = n_parameter - 2; i >= 0; i--) {
        half_second = half_second * s + first;
        first = first * s + q;
        q = q * s + parameter[i];
    }
    jet[0] = q;
    jet[1] = first;
    jet[2] = 2.0 * half_second;
    return true;
}

#define SERIES_OF(s_of, q_of)                                                                      \
    {                                                                                              \
        .model = "series", .s = (s_of), .q = (q_of), .jet = rmap_jet_series,                       \
        .may_be_missing = true                                                                     \
    }

static const struct rmap_jet_model series[3][2] = {
    [RMAP_SERIES_Z] = {SERIES_OF(RMAP_SERIES_Z, RMAP_SERIES_OF_N),
                       SERIES_OF(RMAP_SERIES_Z, RMAP_SERIES_OF_N_SQUARED)},
    [RMAP_SERIES_RHO2] = {SERIES_OF(RMAP_SERIES_RHO2, RMAP_SERIES_OF_N),
                          SERIES_OF(RMAP_SERIES_RHO2, RMAP_SERIES_OF_N_SQUARED)},
    [RMAP_SERIES_R2] = {SERIES_OF(RMAP_SERIES_R2, RMAP_SERIES_OF_N),
                        SERIES_OF(RMAP_SERIES_R2, RMAP_SERIES_OF_N_SQUARED)}};

enum rmap_status rmap_field_series(struct rmap_field **field_ret, enum rmap_series_variable s,
                                   enum rmap_series_of q, int n_channel, int n_coefficient,
                                   const double *coefficient, struct rmap_error *err)
{
    if (n_coefficient < 1)
        return rmap_error_set(err, RMAP_INPUT, "series: give at least one coefficient");
    const struct rmap_parameter finite = {"a coefficient", RMAP_NEED_FINITE};
    for (size_t i = 0; i < (size_t)n_channel * (size_t)n_coefficient; i++) {
        enum rmap_status st = rmap_parameter_check("series", &finite, coefficient[i], err);
        if (st != RMAP_OK)
            return st;
    }
    return rmap_field_of_jet(field_ret, &series[s][q], n_channel, n_coefficient, coefficient, err);
}

/* n_edge^2 (1 + (radius^2 - r^2) / focus^2) (Gutman 1954, J. Appl. Phys. 25, 855) */
static void prepare_gutman(const double *given, double *kept)
{
    double edge2 = given[0] * given[0], ratio = given[1] / given[2];
    kept[0] = edge2 * (1.0 + ratio * ratio);
    kept[1] = -edge2 / (given[2] * given[2]);
}

/* Luneburg 1944, Mathematical Theory of Optics, sec. 28: Gutman's with the focus on the rim */
static void prepare_luneburg(const double *given, double *kept)
{
    const double gutman[3] = {given[0], given[1], given[1]};
    prepare_gutman(gutman, kept);
}

static void prepare_parabolic(const double *given, double *kept)
{
    kept[0] = given[0] * given[0];
    kept[1] = -kept[0] * given[1] * given[1];
}

static void prepare_selfoc(const double *given, double *kept)
{
    kept[0] = given[0];
    kept[1] = -0.5 * given[0] * given[1];
}

static const struct rmap_jet_model gutman = {.model = "gutman",
                                             .s = RMAP_SERIES_R2,
                                             .q = RMAP_SERIES_OF_N_SQUARED,
                                             .jet = rmap_jet_series,
                                             .may_be_missing = true,
                                             .n_parameter = 3,
                                             .parameter = {{"n_edge", RMAP_NEED_POSITIVE},
                                                           {"radius", RMAP_NEED_POSITIVE},
                                                           {"focus", RMAP_NEED_POSITIVE}},
                                             .prepare = prepare_gutman,
                                             .n_kept = 2};

static const struct rmap_jet_model luneburg = {
    .model = "luneburg",
    .s = RMAP_SERIES_R2,
    .q = RMAP_SERIES_OF_N_SQUARED,
    .jet = rmap_jet_series,
    .may_be_missing = true,
    .n_parameter = 2,
    .parameter = {{"n_edge", RMAP_NEED_POSITIVE}, {"radius", RMAP_NEED_POSITIVE}},
    .prepare = prepare_luneburg,
    .n_kept = 2};

static const struct rmap_jet_model parabolic = {
    .model = "parabolic",
    .s = RMAP_SERIES_RHO2,
    .q = RMAP_SERIES_OF_N_SQUARED,
    .jet = rmap_jet_series,
    .may_be_missing = true,
    .n_parameter = 2,
    .parameter = {{"n0", RMAP_NEED_POSITIVE}, {"alpha", RMAP_NEED_FINITE}},
    .prepare = prepare_parabolic,
    .n_kept = 2};

static const struct rmap_jet_model selfoc = {
    .model = "selfoc",
    .s = RMAP_SERIES_RHO2,
    .q = RMAP_SERIES_OF_N,
    .jet = rmap_jet_series,
    .may_be_missing = true,
    .n_parameter = 2,
    .parameter = {{"n0", RMAP_NEED_POSITIVE}, {"A", RMAP_NEED_FINITE}},
    .prepare = prepare_selfoc,
    .n_kept = 2};

enum rmap_status rmap_field_luneburg(struct rmap_field **field_ret, int n_channel,
                                     const struct rmap_luneburg *parameter, struct rmap_error *err)
{
    return rmap_field_of_model(field_ret, &luneburg, n_channel, parameter, err);
}

enum rmap_status rmap_field_gutman(struct rmap_field **field_ret, int n_channel,
                                   const struct rmap_gutman *parameter, struct rmap_error *err)
{
    return rmap_field_of_model(field_ret, &gutman, n_channel, parameter, err);
}

enum rmap_status rmap_field_parabolic(struct rmap_field **field_ret, int n_channel,
                                      const struct rmap_parabolic *parameter,
                                      struct rmap_error *err)
{
    return rmap_field_of_model(field_ret, &parabolic, n_channel, parameter, err);
}

enum rmap_status rmap_field_selfoc(struct rmap_field **field_ret, int n_channel,
                                   const struct rmap_selfoc *parameter, struct rmap_error *err)
{
    return rmap_field_of_model(field_ret, &selfoc, n_channel, parameter, err);
}
