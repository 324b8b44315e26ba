/* SPDX-License-Identifier: MIT
 *
 * A picture as sums over samples, filled tile by tile.
 */
#include "render/film.h"

#include <string.h>

#include "base/alloc.h"
#include "optics/spectrum.h"

enum rmap_status rmap_film_create(const uint32_t size[2], struct rmap_film **film_ret,
                                  struct rmap_error *err)
{
    struct rmap_film *film = rmap_alloc(1, sizeof *film);
    size_t n_value = (size_t)size[0] * size[1] * RMAP_FILM_SUMS;
    double *value = rmap_alloc(n_value, sizeof *value);
    if (!film || !value) {
        rmap_free(film);
        rmap_free(value);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a picture of %u x %u", size[0],
                              size[1]);
    }
    *film = (struct rmap_film){.size = {size[0], size[1]}, .n_value = n_value, .value = value};
    *film_ret = film;
    return RMAP_OK;
}

void rmap_film_destroy(struct rmap_film *film)
{
    if (!film)
        return;
    rmap_free(film->value);
    rmap_free(film);
}

void rmap_film_clear(struct rmap_film *film)
{
    memset(film->value, 0, film->n_value * sizeof *film->value);
    film->n_sample = 0;
}

void rmap_film_add(struct rmap_film *film, const struct rmap_film *other)
{
    for (size_t i = 0; i < film->n_value; i++)
        film->value[i] += other->value[i];
    film->n_sample += other->n_sample;
}

static uint32_t tiles_along(uint32_t n)
{
    return (n + RMAP_TILE_SIDE - 1) / RMAP_TILE_SIDE;
}

uint64_t rmap_film_n_tile(const struct rmap_film *film)
{
    return (uint64_t)tiles_along(film->size[0]) * tiles_along(film->size[1]);
}

static void render_pixel(const struct rmap_renderer *renderer, uint32_t x, uint32_t y,
                         uint64_t first, uint64_t n, struct rmap_render_counts *counts,
                         double sum[RMAP_FILM_SUMS])
{
    double rgb[5];
    memset(sum, 0, RMAP_FILM_SUMS * sizeof *sum);
    for (uint64_t sample = first; sample < first + n; sample++) {
        rmap_render_sample(renderer, x, y, sample, counts, rgb);
        double luminance = rmap_rgb_luminance(rgb);
        for (int k = 0; k < 3; k++)
            sum[k] += rgb[k];
        sum[3] += luminance * luminance;
        sum[4] += rgb[3];
        sum[5] += rgb[4];
    }
}

static uint32_t end_of(uint32_t begin, uint32_t size)
{
    return size - begin < RMAP_TILE_SIDE ? size : begin + RMAP_TILE_SIDE;
}

bool rmap_film_render_tile(struct rmap_film *film, const struct rmap_renderer *renderer,
                           uint64_t tile, uint64_t first, uint64_t n, const atomic_bool *stop,
                           struct rmap_render_counts *counts)
{
    uint32_t across = tiles_along(film->size[0]);
    uint32_t left = (uint32_t)(tile % across) * RMAP_TILE_SIDE;
    uint32_t top = (uint32_t)(tile / across) * RMAP_TILE_SIDE;
    struct rmap_render_counts mine = {0}; /* away from the other threads' */
    for (uint32_t y = top; y < end_of(top, film->size[1]); y++)
        for (uint32_t x = left; x < end_of(left, film->size[0]); x++) {
            if (atomic_load_explicit(stop, memory_order_relaxed))
                return false;
            render_pixel(renderer, x, y, first, n, &mine,
                         film->value + ((size_t)y * film->size[0] + x) * RMAP_FILM_SUMS);
        }
    rmap_render_counts_add(counts, &mine);
    return true;
}

void rmap_film_resolve(const struct rmap_film *film, float *rgb)
{
    double scale = film->n_sample > 0 ? 1.0 / (double)film->n_sample : 0.0;
    for (size_t i = 0; i < film->n_value / RMAP_FILM_SUMS; i++)
        for (size_t k = 0; k < 3; k++)
            rgb[3 * i + k] = (float)(film->value[RMAP_FILM_SUMS * i + k] * scale);
}

void rmap_film_lit(const struct rmap_film *film, uint8_t *lit)
{
    for (size_t i = 0; i < film->n_value / RMAP_FILM_SUMS; i++)
        lit[i] = 2.0 * film->value[RMAP_FILM_SUMS * i + 4] < (double)film->n_sample;
}

void rmap_film_noise(const struct rmap_film *film, double *error, double *mean)
{
    size_t n_pixel = film->n_value / RMAP_FILM_SUMS;
    double n = (double)film->n_sample, variance = 0.0, sum = 0.0;
    for (size_t i = 0; i < n_pixel; i++) {
        const double *value = film->value + RMAP_FILM_SUMS * i;
        double pixel = rmap_rgb_luminance(value) / n;
        sum += pixel;
        variance += fmax(0.0, value[3] / n - pixel * pixel) / (n - 1.0);
    }
    *mean = n_pixel > 0 ? sum / (double)n_pixel : 0.0;
    *error = film->n_sample > 1 ? sqrt(variance / (double)n_pixel) : (double)NAN;
}

double rmap_film_cut(const struct rmap_film *film)
{
    const size_t n_pixel = film->n_value / RMAP_FILM_SUMS;
    double sum = 0.0;
    for (size_t i = 0; i < n_pixel; i++)
        sum += film->value[RMAP_FILM_SUMS * i + 5];
    return film->n_sample > 0 ? sum / ((double)n_pixel * (double)film->n_sample) : 0.0;
}
