/* SPDX-License-Identifier: MIT
 *
 * A lamp as its maker measured it: intensity over both angles about an axis, and the luminous
 * opening that the light comes from.
 *
 * The lamp's frame: gamma 0 is +z, C 0 is +x, C 90 is -y.
 */
#ifndef RMAP_LAMP_H
#define RMAP_LAMP_H

#include <stddef.h>

#include "base/vec.h"
#include "scene/profile.h"

/* Of the opening, centred on the frame's origin; its surface is as bright all over as it is seen
 * from a direction. */
enum rmap_lamp_body { RMAP_LAMP_POINT, RMAP_LAMP_BOX, RMAP_LAMP_CYLINDER, RMAP_LAMP_ELLIPSOID };

struct rmap_lamp {
    struct rmap_profile mean; /* over the azimuth: knots in 1 - cos of the polar angle */
    size_t n_around;          /* 1: the same all around */
    double *turn;             /* [n_around] azimuths in turns, ascending, from 0 and below 1 */
    double *intensity;        /* [mean.n][n_around] of unit flux, 1/sr; linear between, periodic */
    double *below;            /* [mean.n][n_around + 1]: integral over the turns up to each */
    struct rmap_vec3 axis[3]; /* in the lamp's frame: azimuth 0, azimuth 90 degrees, polar 0 */
    double flux;              /* integral of what was measured */
    enum rmap_lamp_body body;
    int along;       /* 0 to 2: axis of a cylinder */
    double size[3];  /* of the body along x, y, z, in the scene's unit; 0: flat, or a line */
    double side[2];  /* of a box: heights of what looks along x, and along y; they begin where z is
                        greatest */
    char title[128]; /* maker and luminaire, for people; may be "" */
};

/* Of a grid of intensities in any unit, >= 0, candela[n_around][n_polar]: linear in both angles
 * between (by half a degree of the polar angle), periodic around, none beyond the first and the
 * last polar angle. Fills all but axis and body. RMAP_INPUT where there is no light; *lamp is the
 * caller's to finish. */
enum rmap_status rmap_lamp_init(const double *around_deg, size_t n_around, const double *polar_deg,
                                size_t n_polar, const double *candela, struct rmap_lamp *lamp,
                                struct rmap_error *err) RMAP_MUST_USE;
/* The body, so many times. */
void rmap_lamp_enlarge(struct rmap_lamp *lamp, double times);
void rmap_lamp_fini(struct rmap_lamp *lamp);

/* A direction of its light in the lamp's frame, by two numbers in (0, 1). As with all that
 * src/compact finds again, by the same operations everywhere. */
struct rmap_vec3 rmap_lamp_draw(const struct rmap_lamp *lamp, const double u[2]);

/* A point of the body that light of this direction leaves from, uniform over what is seen from
 * there, by three numbers in (0, 1). */
struct rmap_vec3 rmap_lamp_point(const struct rmap_lamp *lamp, struct rmap_vec3 direction,
                                 const double u[3]);

/* 1/sr, of unit flux. */
double rmap_lamp_intensity(const struct rmap_lamp *lamp, struct rmap_vec3 direction);

/* Area of the body as seen from a direction; 0: of a point, or a line. */
double rmap_lamp_seen_area(const struct rmap_lamp *lamp, struct rmap_vec3 direction);

/* Where a straight way through the lamp's frame comes to the body from outside: the distance along
 * the unit direction; below 0: nowhere, or to a part that sends no light. */
double rmap_lamp_entered(const struct rmap_lamp *lamp, struct rmap_vec3 from,
                         struct rmap_vec3 direction);

/* A point of the whole surface by three numbers in (0, 1), and in *facing its outward normal times
 * the area over the density with which it was drawn; 0 of a body without an area. */
struct rmap_vec3 rmap_lamp_surface(const struct rmap_lamp *lamp, const double u[3],
                                   struct rmap_vec3 *facing);

#endif
