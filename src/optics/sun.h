/* SPDX-License-Identifier: MIT
 *
 * The sun: where it stands, and how bright its disc is from the middle outwards.
 */
#ifndef RMAP_SUN_H
#define RMAP_SUN_H

#include <stdbool.h>
#include <stdint.h>

/* "2026-06-21T12:00+02:00": date, hours and minutes, perhaps seconds (with a fraction) and the zone
 * ("Z", or hours and minutes ahead of UTC). In seconds since 2000-01-01T12:00 UTC, of days of
 * 86,400. False where it is none, or has no zone. */
bool rmap_time_parse(const char *text, double *seconds_ret);

/* Degrees: azimuth from north over east, in [0, 360), altitude as it is seen, refraction by air of
 * 10 C and 1010 hPa included (Saemundsson 1986). Latitude north positive, longitude east. Michalsky
 * 1988 (doi:10.1016/0038-092X(88)90045-X), good to 0.01 degrees from 1950 to 2050. */
struct rmap_sun_place {
    double azimuth, altitude;
};
struct rmap_sun_place rmap_sun_place(double latitude, double longitude, double seconds);

/* Distance of the sun over its mean, squared and inverted: how much more light there is of it. */
double rmap_sun_nearness(double seconds);

/* Brightness over the angle to the middle. */
enum rmap_sunshape {
    RMAP_SUNSHAPE_PILLBOX, /* the same up to `size` (radians) */
    RMAP_SUNSHAPE_GAUSS,   /* exp(-angle^2 / (2 size^2)) */
    RMAP_SUNSHAPE_BUIE     /* size: circumsolar ratio (Buie, Monger, Dey 2003,
                              doi:10.1016/S0038-092X(03)00125-7), the disc to RMAP_SUN_RIM, and
                              light around it to 43.6 mrad */
};
#define RMAP_SUN_RIM 4.65e-3
/* Beyond which there is nothing, radians. */
double rmap_sunshape_end(enum rmap_sunshape shape, double size);
/* Of any unit, by +, -, x, / and square roots alone. */
double rmap_sunshape_at(enum rmap_sunshape shape, double size, double angle);

#endif
