/* SPDX-License-Identifier: MIT
 *
 * False colours: a path through Oklab (B. Ottosson, "A perceptual color space for image
 * processing", 2020, https://bottosson.github.io/posts/oklab/) from near black over violet, red
 * and yellow to near white, walked at constant speed. Equal steps of value are equal steps of
 * perceived colour, and lightness grows all the way, so it prints in grey as well.
 */
#ifndef RMAP_COLOUR_MAP_H
#define RMAP_COLOUR_MAP_H

#include <stdint.h>

#define RMAP_COLOUR_MAP_STEPS 256

struct rmap_colour_map {
    uint8_t rgb[RMAP_COLOUR_MAP_STEPS][3]; /* sRGB */
};

void rmap_colour_map_init(struct rmap_colour_map *map);

/* Colour of a value in [0, 1], clamped to it; grey for NaN. */
void rmap_colour_map_at(const struct rmap_colour_map *map, double value, uint8_t rgb[3]);

/* sRGB bytes of linear RGB (IEC 61966-2-1), clamped to [0, 1]. */
void rmap_srgb_encode(const double linear[3], uint8_t rgb[3]);

/* And of one such byte: linear, 0 to 1. */
double rmap_srgb_linear(unsigned byte);

/* Linear RGB of an Oklab colour (lightness, a, b), and back. */
void rmap_oklab_to_rgb(const double lab[3], double linear[3]);
void rmap_rgb_to_oklab(const double linear[3], double lab[3]);

#endif
