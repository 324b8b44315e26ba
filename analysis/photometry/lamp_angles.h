/* SPDX-License-Identifier: MIT
 *
 * Data sheets of luminaires: intensities at C-planes and gammas, in cd and per 1000 lm, and the
 * angles of the beam, of a lamp's file or of what an intensity grid registered.
 */
#ifndef RMAP_LAMP_ANGLES_H
#define RMAP_LAMP_ANGLES_H

#include <jansson.h>
#include <stdio.h>

#include "base/status.h"
#include "scene/lamp.h"

/* The direction in the lamp's frame (gamma 0 is +z, C 0 +x, C 90 -y), and the intensity there, of
 * unit flux. Degrees, any C; gamma from 0 to 180. */
struct rmap_vec3 rmap_lamp_direction(double c_deg, double gamma_deg);
double rmap_lamp_at(const struct rmap_lamp *lamp, double c_deg, double gamma_deg);

/* The plane of C and of C + 180. Angles are between the outermost directions to either side of the
 * axis in which the intensity is a half (beam) and a tenth (field) of the greatest in the plane.
 * The axis is that, down or up, to which the greatest is nearer; outermost is up to 90 degrees from
 * it, and beyond that as far as the light goes on. */
struct rmap_lamp_plane {
    double c_deg;
    double peak; /* greatest intensity, of unit flux */
    double peak_c_deg, peak_gamma_deg;
    double beam_deg, field_deg;
};
void rmap_lamp_plane_find(const struct rmap_lamp *lamp, double c_deg,
                          struct rmap_lamp_plane *plane);

/* What is told of a lamp; lists borrowed. */
struct rmap_lamp_sheet {
    const struct rmap_lamp *lamp;
    double flux;
    const char *flux_unit, *unit; /* "lm", "cd" */
    const double *c_deg, *gamma_deg;
    size_t n_c, n_gamma; /* 0: usual ones */
};

/* One line: "beam angle 60.0 x 58.1 deg, ..." of C0-C180 x C90-C270. */
void rmap_lamp_sheet_line(const struct rmap_lamp_sheet *sheet, FILE *out);
enum rmap_status rmap_lamp_sheet_print(const struct rmap_lamp_sheet *sheet, FILE *out,
                                       struct rmap_error *err) RMAP_MUST_USE;
/* "flux" "unit" "planes"; with the intensities, where these are wanted, "C" "gamma" "intensity"
 * and, of lm, "per_klm". */
json_t *rmap_lamp_sheet_json(const struct rmap_lamp_sheet *sheet, bool intensities);

#endif
