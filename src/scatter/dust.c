/* SPDX-License-Identifier: MIT
 *
 * Particles on a surface.
 */
#include "scatter/dust.h"

#include <math.h>

#include "base/alloc.h"
#include "base/portable.h"
#include "base/search.h"
#include "formula/azimuth.h"
#include "optics/mie.h"

/* Rings from a tenth of the largest particle's diffraction to straight back, sizes, points of a
 * ring, and wavelengths for which spheres are worked out: between them the nearest. */
enum { NARROW = 90, RINGS = NARROW + 68, SIZES = 120, POINTS = 4, WAVELENGTHS_MAX = 8 };

void rmap_scatter_dust_destroy(struct rmap_scatter_dust *dust)
{
    if (!dust)
        return;
    rmap_free(dust->edge);
    rmap_free(dust->density);
    rmap_free(dust->below);
    rmap_free(dust);
}

/* Particles larger than d, per square micrometre. */
static double larger_than(const struct rmap_dust_kind *kind, double d)
{
    const double ln10 = 2.30258509299404568402, level = rmap_portable_log(kind->level) / ln10,
                 size = rmap_portable_log(d) / ln10;
    return rmap_portable_exp(ln10 * kind->slope * (level * level - size * size)) / kind->area_um2;
}

static double size_at(const struct rmap_dust_kind *kind, double i)
{
    return rmap_portable_power(2.0 * kind->level, i / SIZES);
}

static void set_edges(double narrowest, struct rmap_scatter_dust *dust)
{
    double cosine, sine;
    const double wide = RMAP_PI / 18.0;
    for (size_t i = 0; i <= RINGS; i++) {
        double angle = i ? narrowest : 0.0;
        if (i > NARROW)
            angle = wide + (RMAP_PI - wide) * (double)(i - NARROW) / (RINGS - NARROW);
        else if (i > 0)
            angle *= rmap_portable_power(wide / narrowest, (double)(i - 1) / (NARROW - 1));
        rmap_azimuth(angle / (4.0 * RMAP_PI), &cosine, &sine);
        dust->edge[i] = i == RINGS ? 1.0 : sine * sine;
    }
}

static double solid_angle(const struct rmap_scatter_dust *dust, size_t ring)
{
    return 4.0 * RMAP_PI * (dust->edge[ring + 1] - dust->edge[ring]);
}

/* One wavelength: density and below of a channel, and the optical thicknesses. */
static enum rmap_status work_out(const struct rmap_dust_kind *kind, double wavelength_um,
                                 const double *cosine, double *intensity,
                                 const struct rmap_scatter_dust *dust, double *density,
                                 double thickness[2], struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const double wave = 2.0 * RMAP_PI / wavelength_um;
    double sum = 0.0;
    thickness[0] = thickness[1] = 0.0;
    for (size_t r = 0; r < RINGS; r++)
        density[r] = 0.0;
    for (int i = 0; i < SIZES; i++) {
        const double d = size_at(kind, i + 0.5);
        const double count =
            larger_than(kind, size_at(kind, i)) - larger_than(kind, size_at(kind, i + 1));
        struct rmap_mie mie;
        RMAP_TRY(rmap_mie_scatter(0.5 * wave * d, kind->n, kind->k, (size_t)RINGS * POINTS, cosine,
                                  intensity, &mie, err));
        thickness[0] += count * 0.25 * RMAP_PI * d * d * mie.scattered;
        thickness[1] += count * 0.25 * RMAP_PI * d * d * mie.extinct;
        for (size_t k = 0; k < (size_t)RINGS * POINTS; k++)
            density[k / POINTS] += count * intensity[k] / (POINTS * wave * wave);
    }
    for (size_t r = 0; r < RINGS; r++)
        sum += density[r] * solid_angle(dust, r);
    for (size_t r = 0; r < RINGS; r++)
        density[r] /= sum;
out:
    return st;
}

static void sum_up(const struct rmap_scatter_dust *dust, size_t row)
{
    double sum = 0.0;
    for (size_t r = 0; r < RINGS; r++) {
        sum += dust->density[row * RINGS + r] * solid_angle(dust, r);
        dust->below[row * RINGS + r] = sum;
    }
}

enum rmap_status rmap_scatter_set_dust(struct rmap_scatter *scatter,
                                       const struct rmap_dust_kind *kind,
                                       const struct rmap_channels *channels, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n_channel = (size_t)channels->n,
                 step = (n_channel + WAVELENGTHS_MAX - 1) / WAVELENGTHS_MAX;
    struct rmap_scatter_dust *dust = rmap_alloc(1, sizeof *dust);
    double *cosine = rmap_alloc((size_t)RINGS * POINTS, sizeof *cosine),
           *intensity = rmap_alloc((size_t)RINGS * POINTS, sizeof *intensity);
    if (dust) {
        dust->n_ring = RINGS;
        dust->edge = rmap_alloc(RINGS + 1, sizeof *dust->edge);
        dust->density = rmap_alloc(n_channel * RINGS, sizeof *dust->density);
        dust->below = rmap_alloc(n_channel * RINGS, sizeof *dust->below);
    }
    if (!dust || !dust->edge || !dust->density || !dust->below || !cosine || !intensity)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for particles"));
    set_edges(0.1 * 1e-3 * channels->wavelength_nm[0] / (2.0 * kind->level), dust);
    for (size_t k = 0; k < (size_t)RINGS * POINTS; k++) {
        const double *edge = dust->edge + k / POINTS;
        cosine[k] =
            1.0 - 2.0 * (edge[0] + (edge[1] - edge[0]) * ((double)(k % POINTS) + 0.5) / POINTS);
    }
    for (size_t c = 0; c < n_channel; c++) {
        double *density = dust->density + c * RINGS, thickness[2];
        const size_t middle = c / step * step + step / 2, of = middle < n_channel ? middle : c;
        if (c % step == 0) {
            RMAP_TRY(work_out(kind, 1e-3 * channels->wavelength_nm[of], cosine, intensity, dust,
                              density, thickness, err));
            scatter->shape[RMAP_SHAPE_SCATTERED][c] = thickness[0];
            scatter->shape[RMAP_SHAPE_EXTINCT][c] = thickness[1];
        } else {
            for (size_t r = 0; r < RINGS; r++)
                density[r] = (density - RINGS)[r];
            for (int k = 0; k < 2; k++)
                scatter->shape[k][c] = scatter->shape[k][c - 1];
        }
        scatter->amount[c] = 1.0;
        sum_up(dust, c);
    }
    for (int i = 0; i < SIZES; i++) {
        const double d = size_at(kind, i + 0.5);
        dust->coverage +=
            0.25 * RMAP_PI * d * d *
            (larger_than(kind, size_at(kind, i)) - larger_than(kind, size_at(kind, i + 1)));
    }
    scatter->by_wavelength = n_channel > 1;
    scatter->dust = dust;
    dust = NULL;
out:
    rmap_scatter_dust_destroy(dust);
    rmap_free(cosine);
    rmap_free(intensity);
    return st;
}

static double density_at(const struct rmap_scattering *at, double sin2)
{
    const struct rmap_scatter_dust *dust = at->scatter->dust;
    return dust->density[(size_t)at->channel * dust->n_ring +
                         rmap_first_above(dust->edge + 1, dust->n_ring, sin2)];
}

/* Light that a particle sends into the mirror comes back from it. */
double rmap_dust_shape(const struct rmap_scattering *at, struct rmap_vec3 axis,
                       struct rmap_vec3 out)
{
    const struct rmap_vec3 below = {out.x, out.y, -out.z};
    return (density_at(at, 0.5 * (1.0 - rmap_dot(axis, out))) +
            density_at(at, 0.5 * (1.0 - rmap_dot(axis, below)))) /
           out.z;
}

struct rmap_vec3 rmap_dust_draw(const struct rmap_scattering *at, struct rmap_vec3 axis,
                                const struct rmap_draw *draw)
{
    const struct rmap_scatter_dust *dust = at->scatter->dust;
    double u[4], cosine, sine;
    struct rmap_vec3 x, y;
    rmap_rng(draw->seed, draw->ray, draw->step, RMAP_RNG_LOBE, u);
    const size_t ring =
        rmap_first_above(dust->below + (size_t)at->channel * dust->n_ring, dust->n_ring, u[0]);
    const double sin2 = dust->edge[ring] + u[1] * (dust->edge[ring + 1] - dust->edge[ring]),
                 away = 2.0 * sqrt(sin2 * (1.0 - sin2));
    rmap_basis(axis, &x, &y);
    rmap_azimuth(u[2], &cosine, &sine);
    struct rmap_vec3 out =
        rmap_axpy(1.0 - 2.0 * sin2, axis, rmap_axpy(away * cosine, x, rmap_scale(y, away * sine)));
    if (out.z < 0.0)
        out.z = -out.z;
    return out;
}
