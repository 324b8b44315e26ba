/* SPDX-License-Identifier: MIT
 *
 * Particles on a surface.
 */
#include "scatter/dust.h"

#include <math.h>
#include <string.h>

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
    rmap_free(dust->onward);
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
static enum rmap_status work_out(const struct rmap_dust_kind *kind, size_t channel,
                                 double wavelength_um, const double *cosine, double *intensity,
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
        RMAP_TRY(rmap_mie_scatter(0.5 * wave * d, kind->n[channel], kind->k[channel],
                                  (size_t)RINGS * POINTS, cosine, intensity, &mie, err));
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

/* Of a circle about the axis, the part on the far side of a plane at this cosine to it. */
static double part_onward(double cosine, double sin2)
{
    const double along = (1.0 - 2.0 * sin2) * cosine,
                 swing = 2.0 * sqrt(sin2 * (1.0 - sin2)) * sqrt((1.0 - cosine) * (1.0 + cosine));
    if (!(swing > fabs(along)))
        return along < 0.0 ? 0.0 : 1.0;
    const double c = -along / swing;
    return rmap_portable_angle(c, sqrt((1.0 - c) * (1.0 + c))) / RMAP_PI;
}

static void set_onward(const struct rmap_scatter_dust *dust, size_t row)
{
    for (size_t k = 0; k <= RMAP_TOTAL_STEPS; k++) {
        const double v = (double)k / RMAP_TOTAL_STEPS;
        double sum = 0.0;
        for (size_t i = 0; i < (size_t)RINGS * POINTS; i++) {
            const double *edge = dust->edge + i / POINTS;
            const double sin2 =
                edge[0] + (edge[1] - edge[0]) * ((double)(i % POINTS) + 0.5) / POINTS;
            sum += dust->density[row * RINGS + i / POINTS] * solid_angle(dust, i / POINTS) /
                   POINTS * part_onward(v * v, sin2);
        }
        dust->onward[row * (RMAP_TOTAL_STEPS + 1) + k] = sum;
    }
}

static enum rmap_status create(size_t n_channel, struct rmap_scatter_dust **dust_ret,
                               struct rmap_error *err)
{
    struct rmap_scatter_dust *dust = rmap_alloc(1, sizeof *dust);
    if (dust) {
        dust->n_ring = RINGS;
        dust->edge = rmap_alloc(RINGS + 1, sizeof *dust->edge);
        dust->density = rmap_alloc(n_channel * RINGS, sizeof *dust->density);
        dust->below = rmap_alloc(n_channel * RINGS, sizeof *dust->below);
        dust->onward = rmap_alloc(n_channel * (RMAP_TOTAL_STEPS + 1), sizeof *dust->onward);
    }
    *dust_ret = dust;
    return dust && dust->edge && dust->density && dust->below && dust->onward
               ? RMAP_OK
               : rmap_error_set(err, RMAP_SYSTEM, "out of memory for particles");
}

/* A channel's numbers are those of another's. */
static void copy_channel(const struct rmap_scatter *from, const struct rmap_scatter_dust *from_dust,
                         size_t k, struct rmap_scatter *scatter, struct rmap_scatter_dust *dust,
                         size_t c)
{
    const size_t n = RMAP_TOTAL_STEPS + 1;
    memcpy(dust->density + c * RINGS, from_dust->density + k * RINGS,
           RINGS * sizeof *dust->density);
    memcpy(dust->below + c * RINGS, from_dust->below + k * RINGS, RINGS * sizeof *dust->below);
    memcpy(dust->onward + c * n, from_dust->onward + k * n, n * sizeof *dust->onward);
    for (int i = 0; i < 2; i++)
        scatter->shape[i][c] = from->shape[i][k];
}

static enum rmap_status work_out_all(const struct rmap_channels *channels,
                                     struct rmap_scatter *scatter, struct rmap_scatter_dust *dust,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_dust_kind *kind = &dust->kind;
    const size_t n_channel = (size_t)channels->n,
                 step = (n_channel + WAVELENGTHS_MAX - 1) / WAVELENGTHS_MAX;
    double *cosine = rmap_alloc((size_t)RINGS * POINTS, sizeof *cosine),
           *intensity = rmap_alloc((size_t)RINGS * POINTS, sizeof *intensity);
    if (!cosine || !intensity)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for particles"));
    set_edges(0.1 * 1e-3 * channels->wavelength_nm[0] / (2.0 * kind->level), dust);
    for (size_t k = 0; k < (size_t)RINGS * POINTS; k++) {
        const double *edge = dust->edge + k / POINTS;
        cosine[k] =
            1.0 - 2.0 * (edge[0] + (edge[1] - edge[0]) * ((double)(k % POINTS) + 0.5) / POINTS);
    }
    for (size_t c = 0; c < n_channel; c++) {
        const size_t middle = c / step * step + step / 2, of = middle < n_channel ? middle : c;
        double thickness[2];
        if (c % step != 0) {
            copy_channel(scatter, dust, c - 1, scatter, dust, c);
            continue;
        }
        RMAP_TRY(work_out(kind, of, 1e-3 * channels->wavelength_nm[of], cosine, intensity, dust,
                          dust->density + c * RINGS, thickness, err));
        scatter->shape[RMAP_SHAPE_SCATTERED][c] = thickness[0];
        scatter->shape[RMAP_SHAPE_EXTINCT][c] = thickness[1];
        sum_up(dust, c);
        set_onward(dust, c);
    }
    for (int i = 0; i < SIZES; i++) {
        const double d = size_at(kind, i + 0.5);
        dust->coverage +=
            0.25 * RMAP_PI * d * d *
            (larger_than(kind, size_at(kind, i)) - larger_than(kind, size_at(kind, i + 1)));
    }
out:
    rmap_free(cosine);
    rmap_free(intensity);
    return st;
}

/* Spheres of that kind that are there; NULL: none. */
static const struct rmap_scatter *find_alike(const struct rmap_dust_kind *kind, size_t n_channel,
                                             const struct rmap_scatter *others, size_t n_other)
{
    const size_t nbytes = n_channel * sizeof *kind->n;
    for (size_t i = 0; i < n_other; i++) {
        const struct rmap_dust_kind *its = others[i].dust ? &others[i].dust->kind : NULL;
        if (its && its->level == kind->level && its->slope == kind->slope &&
            its->area_um2 == kind->area_um2 && memcmp(its->n, kind->n, nbytes) == 0 &&
            memcmp(its->k, kind->k, nbytes) == 0)
            return &others[i];
    }
    return NULL;
}

enum rmap_status rmap_scatter_set_dust(struct rmap_scatter *scatter,
                                       const struct rmap_dust_kind *kind,
                                       const struct rmap_channels *channels,
                                       const struct rmap_scatter *others, size_t n_other,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scatter *alike = find_alike(kind, (size_t)channels->n, others, n_other);
    struct rmap_scatter_dust *dust = NULL;
    RMAP_TRY(create((size_t)channels->n, &dust, err));
    dust->kind = *kind;
    if (alike) {
        memcpy(dust->edge, alike->dust->edge, (RINGS + 1) * sizeof *dust->edge);
        for (size_t c = 0; c < (size_t)channels->n; c++)
            copy_channel(alike, alike->dust, c, scatter, dust, c);
        dust->coverage = alike->dust->coverage;
    } else {
        RMAP_TRY(work_out_all(channels, scatter, dust, err));
    }
    for (int c = 0; c < channels->n; c++)
        scatter->amount[c] = 1.0;
    scatter->by_wavelength = channels->n > 1;
    scatter->dust = dust;
    dust = NULL;
out:
    rmap_scatter_dust_destroy(dust);
    return st;
}

/* ---- light that passes them ---- */

/* In the medium that they lie in, the direction about which light is scattered, and the side of the
 * surface that it goes on to. */
struct passage {
    struct rmap_vec3 axis;
    double bend; /* index on the side asked for over that where particles lie */
    double side; /* +1, -1: sign of z where light is asked for */
};

/* The direction beyond a boundary, on a side; along it where none leads there. */
static struct rmap_vec3 bent(struct rmap_vec3 in, double ratio, double side)
{
    struct rmap_vec3 beta = {ratio * in.x, ratio * in.y, 0.0};
    const double square = beta.x * beta.x + beta.y * beta.y;
    if (!(square < 1.0))
        return rmap_scale(beta, 1.0 / sqrt(square));
    beta.z = side * sqrt(1.0 - square);
    return beta;
}

static struct passage passage_of(const struct rmap_scattering *at)
{
    const double side = at->passes ? -1.0 : 1.0;
    if (at->beyond)
        return (struct passage){bent(at->in, at->n1 / at->n2, -1.0),
                                at->passes ? 1.0 : at->n1 / at->n2, side};
    return (struct passage){at->passes ? at->in : bent(at->in, 1.0, 1.0),
                            at->passes ? at->n2 / at->n1 : 1.0, side};
}

static double density_at(const struct rmap_scattering *at, double sin2)
{
    const struct rmap_scatter_dust *dust = at->scatter->dust;
    return dust->density[(size_t)at->channel * dust->n_ring +
                         rmap_first_above(dust->edge + 1, dust->n_ring, sin2)];
}

/* Light that a particle sends into a mirror comes back from it. */
double rmap_dust_shape(const struct rmap_scattering *at, struct rmap_vec3 out)
{
    const struct passage its = passage_of(at);
    if (its.bend != 1.0)
        out = bent(out, its.bend, its.side);
    if (out.z == 0.0)
        return 0.0;
    const double from_axis = density_at(at, 0.5 * (1.0 - rmap_dot(its.axis, out))),
                 scale = its.bend * its.bend / fabs(out.z);
    if (at->passes || at->beyond)
        return (at->passes ? at->ahead : at->back) * from_axis * scale;
    const struct rmap_vec3 below = {out.x, out.y, -out.z};
    return (at->ahead * from_axis +
            at->back * density_at(at, 0.5 * (1.0 - rmap_dot(its.axis, below)))) *
           scale;
}

double rmap_dust_onward(const struct rmap_scatter *scatter, int channel, double cosine)
{
    const double *onward = scatter->dust->onward + (size_t)channel * (RMAP_TOTAL_STEPS + 1),
                 where = RMAP_TOTAL_STEPS * sqrt(cosine);
    const int k = where < RMAP_TOTAL_STEPS - 1 ? (int)where : RMAP_TOTAL_STEPS - 1;
    return onward[k] + (where - k) * (onward[k + 1] - onward[k]);
}

double rmap_dust_total(const struct rmap_scattering *at)
{
    const double onward = rmap_dust_onward(at->scatter, at->channel, fabs(passage_of(at).axis.z));
    if (at->passes)
        return at->ahead * onward;
    return at->beyond ? at->back * (1.0 - onward)
                      : at->ahead + (at->back - at->ahead) * (1.0 - onward);
}

static struct rmap_vec3 draw_about(const struct rmap_scattering *at, struct rmap_vec3 axis,
                                   const double u[4])
{
    const struct rmap_scatter_dust *dust = at->scatter->dust;
    double cosine, sine;
    struct rmap_vec3 x, y;
    const size_t ring =
        rmap_first_above(dust->below + (size_t)at->channel * dust->n_ring, dust->n_ring, u[0]);
    const double sin2 = dust->edge[ring] + u[1] * (dust->edge[ring + 1] - dust->edge[ring]),
                 away = 2.0 * sqrt(sin2 * (1.0 - sin2));
    rmap_basis(axis, &x, &y);
    rmap_azimuth(u[2], &cosine, &sine);
    return rmap_axpy(1.0 - 2.0 * sin2, axis,
                     rmap_axpy(away * cosine, x, rmap_scale(y, away * sine)));
}

/* Into the medium on the side that is asked for. False: it does not get there. */
static bool arrives(const struct passage *its, struct rmap_vec3 *out)
{
    if (!(its->side * out->z > 0.0))
        return false;
    if (its->bend == 1.0)
        return true;
    *out = bent(*out, 1.0 / its->bend, its->side);
    return out->z != 0.0;
}

struct rmap_vec3 rmap_dust_draw(const struct rmap_scattering *at, const struct rmap_draw *draw)
{
    const struct passage its = passage_of(at);
    const double most = at->ahead > at->back ? at->ahead : at->back;
    double u[4];
    for (int k = 0; k < RMAP_TRIES_MAX; k++) {
        rmap_rng(draw->seed, draw->ray, draw->step, (enum rmap_rng_slot)(RMAP_RNG_LOBE + k), u);
        struct rmap_vec3 out = draw_about(at, its.axis, u);
        if (at->passes || at->beyond) {
            if (arrives(&its, &out))
                return out;
        } else if (most * u[3] < (out.z < 0.0 ? at->back : at->ahead)) {
            return rmap_vec3(out.x, out.y, fabs(out.z));
        }
    }
    return rmap_vec3(its.axis.x, its.axis.y, its.side * fabs(its.axis.z));
}
