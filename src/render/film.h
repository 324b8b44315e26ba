/* SPDX-License-Identifier: MIT
 *
 * A picture as sums over samples, filled tile by tile.
 */
#ifndef RMAP_FILM_H
#define RMAP_FILM_H

#include <stdatomic.h>

#include "render/renderer.h"

/* Red, green, blue, square of the luminance, samples that saw a light itself, luminance cut off. */
#define RMAP_FILM_SUMS 6
#define RMAP_TILE_SIDE 8

struct rmap_film {
    uint32_t size[2];
    uint64_t n_sample; /* per pixel */
    size_t n_value;
    double *value; /* [size[1]][size[0]][RMAP_FILM_SUMS], upper row first */
};

enum rmap_status rmap_film_create(const uint32_t size[2], struct rmap_film **film_ret,
                                  struct rmap_error *err) RMAP_MUST_USE;
void rmap_film_destroy(struct rmap_film *film);
void rmap_film_clear(struct rmap_film *film);

/* Adds the sums and the samples of another film of the same size. */
void rmap_film_add(struct rmap_film *film, const struct rmap_film *other);

uint64_t rmap_film_n_tile(const struct rmap_film *film);

/* Writes the sums of samples [first, first + n) of each pixel of a tile; tiles may be rendered by
 * several threads at once. The film's n_sample is the caller's affair. False, with a part of the
 * tile and without its counts, when *stop became true on the way. */
bool rmap_film_render_tile(struct rmap_film *film, const struct rmap_renderer *renderer,
                           uint64_t tile, uint64_t first, uint64_t n, const atomic_bool *stop,
                           struct rmap_render_counts *counts);

/* Mean over the samples, linear RGB: [size[1]][size[0]][3]. */
void rmap_film_resolve(const struct rmap_film *film, float *rgb);

/* lit: [size[1]][size[0]] 1 where a light itself fills less than half of the pixel, else 0. */
void rmap_film_lit(const struct rmap_film *film, uint8_t *lit);

/* Root mean square over the picture of the pixels' standard errors of luminance, and the mean
 * luminance; an error of NaN with fewer than 2 samples. */
void rmap_film_noise(const struct rmap_film *film, double *error, double *mean);

/* Mean luminance that the renderer's clamp took away. */
double rmap_film_cut(const struct rmap_film *film);

#endif
