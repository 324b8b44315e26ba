/* SPDX-License-Identifier: MIT
 *
 * False colours: a path through Oklab (B. Ottosson, "A perceptual color space for image
 * processing", 2020, https://bottosson.github.io/posts/oklab/) from near black over violet, red
 * and yellow to near white, walked at constant speed.
 */
#include "analysis/table/colour_map.h"

#include <math.h>
#include <stddef.h>

#include "base/vec.h"

/* The path's corners: lightness, chroma, hue in degrees. Chosen inside the sRGB gamut (the unit
 * test checks that nothing is clipped). */
static const double corner[][3] = {{0.12, 0.045, 285}, {0.30, 0.150, 295}, {0.46, 0.190, 325},
                                   {0.61, 0.195, 370}, {0.74, 0.160, 410}, {0.87, 0.155, 450},
                                   {0.975, 0.06, 465}};

enum { CORNERS = sizeof corner / sizeof *corner, PER_SPAN = 128 };

void rmap_oklab_to_rgb(const double lab[3], double linear[3])
{
    double l = lab[0] + 0.3963377774 * lab[1] + 0.2158037573 * lab[2];
    double m = lab[0] - 0.1055613458 * lab[1] - 0.0638541728 * lab[2];
    double s = lab[0] - 0.0894841775 * lab[1] - 1.2914855480 * lab[2];
    l = l * l * l;
    m = m * m * m;
    s = s * s * s;
    linear[0] = 4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s;
    linear[1] = -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s;
    linear[2] = -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s;
}

void rmap_rgb_to_oklab(const double linear[3], double lab[3])
{
    double r = linear[0], g = linear[1], b = linear[2];
    double l = cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
    double m = cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
    double s = cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
    lab[0] = 0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s;
    lab[1] = 1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s;
    lab[2] = 0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s;
}

void rmap_srgb_encode(const double linear[3], uint8_t rgb[3])
{
    for (int k = 0; k < 3; k++) {
        double u = isnan(linear[k]) ? 0.0 : fmin(fmax(linear[k], 0.0), 1.0);
        u = u <= 0.0031308 ? 12.92 * u : 1.055 * pow(u, 1.0 / 2.4) - 0.055;
        rgb[k] = (uint8_t)(255.0 * u + 0.5);
    }
}

/* Corner i of the path in Oklab; beyond the ends, mirrored, so that a spline has neighbours. */
static struct rmap_vec3 corner_at(int i)
{
    if (i < 0)
        return rmap_sub(rmap_scale(corner_at(0), 2.0), corner_at(1));
    if (i >= CORNERS)
        return rmap_sub(rmap_scale(corner_at(CORNERS - 1), 2.0), corner_at(CORNERS - 2));
    double hue = corner[i][2] * RMAP_PI / 180.0;
    return rmap_vec3(corner[i][0], corner[i][1] * cos(hue), corner[i][1] * sin(hue));
}

/* Catmull-Rom spline through the corners, u in [0, CORNERS - 1]. */
static struct rmap_vec3 path_at(double u)
{
    int i = (int)fmin(floor(u), CORNERS - 2);
    double t = u - i;
    struct rmap_vec3 sum = rmap_scale(corner_at(i - 1), 0.5 * t * (-1.0 + t * (2.0 - t)));
    sum = rmap_axpy(0.5 * (2.0 + t * t * (-5.0 + 3.0 * t)), corner_at(i), sum);
    sum = rmap_axpy(0.5 * t * (1.0 + t * (4.0 - 3.0 * t)), corner_at(i + 1), sum);
    return rmap_axpy(0.5 * t * t * (t - 1.0), corner_at(i + 2), sum);
}

void rmap_colour_map_init(struct rmap_colour_map *map)
{
    enum { N = (CORNERS - 1) * PER_SPAN };
    double length[N + 1] = {0.0};
    for (int i = 1; i <= N; i++)
        length[i] = length[i - 1] + rmap_length(rmap_sub(path_at((double)i / PER_SPAN),
                                                         path_at((double)(i - 1) / PER_SPAN)));
    int at = 1;
    for (int k = 0; k < RMAP_COLOUR_MAP_STEPS; k++) {
        double wanted = length[N] * k / (RMAP_COLOUR_MAP_STEPS - 1);
        while (at < N && length[at] < wanted)
            at++;
        double part = (wanted - length[at - 1]) / (length[at] - length[at - 1]);
        struct rmap_vec3 p = path_at((at - 1 + part) / PER_SPAN);
        double linear[3];
        rmap_oklab_to_rgb((const double[3]){p.x, p.y, p.z}, linear);
        rmap_srgb_encode(linear, map->rgb[k]);
    }
}

double rmap_srgb_linear(unsigned byte)
{
    const double v = byte / 255.0;
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

void rmap_colour_map_at(const struct rmap_colour_map *map, double value, uint8_t rgb[3])
{
    static const uint8_t unknown[3] = {128, 128, 128};
    const uint8_t *found = unknown;
    if (!isnan(value))
        found = map->rgb[(int)(fmin(fmax(value, 0.0), 1.0) * (RMAP_COLOUR_MAP_STEPS - 1) + 0.5)];
    for (int k = 0; k < 3; k++)
        rgb[k] = found[k];
}
