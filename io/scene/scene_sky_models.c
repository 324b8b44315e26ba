/* SPDX-License-Identifier: MIT
 *
 * Skies and the sun as grids of radiance over direction.
 */
#include "io/scene/scene_sky_models.h"

#include "formula/azimuth.h"

/* Half a degree. */
enum { SKY_ROWS = 180, SKY_COLUMNS = 720, SUN_ROWS = 400, SUN_COLUMNS = 24 };

enum rmap_status rmap_sky_of_pattern(const struct rmap_sky_pattern *pattern,
                                     const struct rmap_sun_seen *sun, struct rmap_sky *sky,
                                     struct rmap_error *err)
{
    const struct rmap_vec3 to_sun =
        rmap_sky_direction(sun->azimuth, sun->known ? sun->altitude : 90.0);
    const double zenith = rmap_sky_pattern_at(pattern, 1.0, to_sun.z);
    const enum rmap_status st = rmap_sky_init(sky, SKY_ROWS, SKY_COLUMNS, false, err);
    if (st != RMAP_OK)
        return st;
    rmap_sky_even_rows(sky, 0, 0.0, sky->n_row, 90.0);
    for (size_t r = 0; r < sky->n_row; r++) {
        double cosine, sine, c, s;
        rmap_azimuth(((double)r + 0.5) / (4.0 * SKY_ROWS), &cosine, &sine);
        for (size_t k = 0; k < sky->n_around; k++) {
            rmap_azimuth(((double)k + 0.5) / SKY_COLUMNS, &c, &s);
            const double cos_sun = rmap_dot(to_sun, rmap_vec3(sine * c, sine * s, cosine));
            sky->radiance[r * SKY_COLUMNS + k] =
                rmap_sky_pattern_at(pattern, cosine, cos_sun) / zenith;
        }
    }
    return RMAP_OK;
}

enum rmap_status rmap_sky_of_all(struct rmap_sky *sky, struct rmap_error *err)
{
    const enum rmap_status st = rmap_sky_init(sky, 2 * SKY_ROWS, SKY_COLUMNS, false, err);
    if (st != RMAP_OK)
        return st;
    rmap_sky_even_rows(sky, 0, 0.0, sky->n_row, 180.0);
    for (size_t i = 0; i < sky->n_row * sky->n_around; i++)
        sky->radiance[i] = 1.0;
    return RMAP_OK;
}

enum rmap_status rmap_sky_of_sun(enum rmap_sunshape shape, double size, struct rmap_sky *sky,
                                 struct rmap_error *err)
{
    const double end = rmap_sunshape_end(shape, size),
                 rim = shape == RMAP_SUNSHAPE_BUIE ? RMAP_SUN_RIM : 0.5 * end;
    const enum rmap_status st = rmap_sky_init(sky, SUN_ROWS, SUN_COLUMNS, false, err);
    if (st != RMAP_OK)
        return st;
    rmap_sky_even_rows(sky, 0, 0.0, SUN_ROWS / 2, rim * 180.0 / RMAP_PI);
    rmap_sky_even_rows(sky, SUN_ROWS / 2, rim * 180.0 / RMAP_PI, SUN_ROWS, end * 180.0 / RMAP_PI);
    for (size_t r = 0; r < sky->n_row; r++) {
        const double part = ((double)r + 0.5) / (SUN_ROWS / 2),
                     angle = part < 1.0 ? rim * part : rim + (end - rim) * (part - 1.0),
                     bright = rmap_sunshape_at(shape, size, angle);
        for (size_t k = 0; k < sky->n_around; k++)
            sky->radiance[r * sky->n_around + k] = bright;
    }
    return RMAP_OK;
}
