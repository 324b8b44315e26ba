/* SPDX-License-Identifier: MIT
 *
 * Beams: Gaussian ones, and collimated ones that are not as bright all over.
 */
#include "io/scene/scene_beams.h"

#include <math.h>

#include "base/alloc.h"
#include "io/scene/scene_objects.h"
#include "io/scene/scene_quantity.h"

void rmap_reader_read_beam(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           struct rmap_source *source)
{
    static const struct rmap_range angle = {
        1e-9, 80, "an angle greater than 0 and up to 80 degrees", RMAP_DIMENSION_ANGLE};
    double waist = 1, divergence = 0, nm = 0, waist_at = 0;
    const bool has_angle = rmap_yaml_get(node, "divergence"),
               has_nm = rmap_yaml_get(node, "wavelength");
    source->shape = RMAP_EMITTER_POINT;
    source->distribution = RMAP_DISTRIBUTION_CONE; /* for who asks: not one direction */
    bool good = rmap_reader_number(reader, node, "waist", RMAP_REQUIRED,
                                   &rmap_range_positive_length, &waist);
    good &= rmap_reader_number(reader, node, "divergence", RMAP_OPTIONAL, &angle, &divergence);
    good &=
        rmap_reader_number(reader, node, "wavelength", RMAP_OPTIONAL, &rmap_range_wavelength, &nm);
    good &=
        rmap_reader_number(reader, node, "waist_at", RMAP_OPTIONAL, &rmap_range_length, &waist_at);
    if (has_angle == has_nm)
        rmap_reader_error(reader, node,
                          "give 'wavelength', by which a beam of this waist spreads, or "
                          "'divergence', its half angle far away, of 1/e^2");
    const double wavelength = 1e-9 * nm / reader->scene->unit_m,
                 rayleigh = has_angle ? waist / tan(divergence * RMAP_PI / 180)
                                      : RMAP_PI * waist * waist / wavelength;
    source->shape_size[0] = waist;
    source->shape_size[1] = good && rayleigh > 0 ? rayleigh : 1;
    source->cone_rad = waist_at;
}

/* ---- irradiance over a disc ---- */

enum { KNOTS = 2048 };

/* At a distance from the middle; straight between rows, none outside. */
static double between(double *const column[2], size_t n, double r)
{
    for (size_t i = 1; i < n; i++)
        if (r >= column[0][i - 1] && r <= column[0][i])
            return column[1][i - 1] + (column[1][i] - column[1][i - 1]) * (r - column[0][i - 1]) /
                                          (column[0][i] - column[0][i - 1]);
    return 0;
}

void rmap_reader_read_profile(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                              struct rmap_source *source)
{
    const struct rmap_yaml_node *profile = rmap_yaml_get(node, "profile");
    double *column[2] = {NULL, NULL}, w = 0;
    size_t n = 0;
    if (!profile)
        return;
    if (source->shape != RMAP_EMITTER_DISC || !(source->shape_size[0] > 0)) {
        rmap_reader_error(reader, profile, "'profile' is of a disc: shape: {disc: radius}");
        return;
    }
    if (rmap_yaml_get(profile, "gaussian")) {
        if (!rmap_reader_check_map(reader, profile, "a profile", "gaussian") ||
            !rmap_reader_number(reader, profile, "gaussian", RMAP_REQUIRED,
                                &rmap_range_positive_length, &w))
            return;
    } else {
        rmap_reader_table(reader, profile, "radius value", 2, &rmap_range_nonnegative, &n, column);
        if (n == 0)
            return;
    }
    source->profile.knot = rmap_alloc(KNOTS, sizeof *source->profile.knot);
    if (!source->profile.knot) {
        rmap_reader_no_memory(reader);
        return;
    }
    source->profile.n = KNOTS;
    for (size_t k = 0; k < KNOTS; k++) {
        const double share = (double)k / (KNOTS - 1), r = source->shape_size[0] * sqrt(share);
        source->profile.knot[k] = (struct rmap_profile_knot){
            .one_minus_cos = 2 * share,
            .intensity = w > 0 ? exp(-2 * r * r / (w * w)) : between(column, n, r)};
    }
    if (!(rmap_profile_sum(&source->profile) > 0))
        rmap_reader_error(reader, profile, "the beam has no light within its disc");
}
