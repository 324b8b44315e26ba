/* SPDX-License-Identifier: MIT
 *
 * Eaton's lens (Eaton 1952, IRE Trans. Antennas Propag. 4, 66): light goes in Kepler ellipses about
 * the centre and comes back the way it came.
 */
#include "gradient/field_internal.h"

/* n^2 = n_edge^2 (2 R / r - 1); parameter: {n_edge^2, 2 R} */
static bool jet_eaton(const double *parameter, int n_parameter, double s, double jet[3])
{
    (void)n_parameter;
    if (!(s > 0.0))
        return false;
    double pull = parameter[0] * parameter[1] / sqrt(s);
    jet[0] = pull - parameter[0];
    jet[1] = -0.5 * pull / s;
    jet[2] = 0.75 * pull / (s * s);
    return true;
}

static void prepare_eaton(const double *given, double *kept)
{
    kept[0] = given[0] * given[0];
    kept[1] = 2.0 * given[1];
}

static const struct rmap_jet_model eaton = {
    .model = "eaton",
    .s = RMAP_SERIES_R2,
    .q = RMAP_SERIES_OF_N_SQUARED,
    .jet = jet_eaton,
    .may_be_missing = true,
    .n_parameter = 2,
    .parameter = {{"n_edge", RMAP_NEED_POSITIVE}, {"radius", RMAP_NEED_POSITIVE}},
    .prepare = prepare_eaton,
    .n_kept = 2};

enum rmap_status rmap_field_eaton(struct rmap_field **field_ret, int n_channel,
                                  const struct rmap_eaton *parameter, struct rmap_error *err)
{
    return rmap_field_of_model(field_ret, &eaton, n_channel, parameter, err);
}
