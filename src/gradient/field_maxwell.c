/* SPDX-License-Identifier: MIT
 *
 * Maxwell's fish-eye (1854; Born & Wolf, Principles of Optics, 7th ed., 4.2.2): light goes in
 * circles, every point has a perfect image.
 */
#include "gradient/field_internal.h"

/* parameter: {n_centre, 1 / radius^2} */
static bool jet_maxwell(const double *parameter, int n_parameter, double s, double jet[3])
{
    (void)n_parameter;
    double k = parameter[1], scale = 1.0 / (1.0 + k * s);
    jet[0] = parameter[0] * scale;
    jet[1] = -k * scale * jet[0];
    jet[2] = -2.0 * k * scale * jet[1];
    return true;
}

static void prepare_maxwell(const double *given, double *kept)
{
    kept[0] = given[0];
    kept[1] = 1.0 / (given[1] * given[1]);
}

static const struct rmap_jet_model maxwell = {
    .model = "maxwell",
    .s = RMAP_SERIES_R2,
    .q = RMAP_SERIES_OF_N,
    .jet = jet_maxwell,
    .n_parameter = 2,
    .parameter = {{"n_centre", RMAP_NEED_POSITIVE}, {"radius", RMAP_NEED_POSITIVE}},
    .prepare = prepare_maxwell,
    .n_kept = 2};

enum rmap_status rmap_field_maxwell(struct rmap_field **field_ret, int n_channel,
                                    const struct rmap_maxwell *parameter, struct rmap_error *err)
{
    return rmap_field_of_model(field_ret, &maxwell, n_channel, parameter, err);
}
