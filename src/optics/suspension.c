/* SPDX-License-Identifier: MIT
 *
 * Light scattered by many spheres, each by itself.
 */
#include "optics/suspension.h"

#include "base/alloc.h"
#include "base/portable.h"
#include "base/vec.h"

/* Steps of a log-normal distribution, in standard deviations of the logarithm from the median: the
 * larger spheres, whose light goes by up to the sixth power, lie up to six of their logarithms
 * higher. */
enum { SIZES = 96 };
static const double reach = 4.5;

static double most_of(const struct rmap_suspension *its)
{
    return reach + 6.0 * rmap_portable_log(its->sigma);
}

static double size_at(const struct rmap_suspension *its, double deviations)
{
    return its->diameter * rmap_portable_power(its->sigma, deviations);
}

double rmap_suspension_largest(const struct rmap_suspension *its)
{
    return its->sigma > 1.0 ? size_at(its, most_of(its)) : its->diameter;
}

enum rmap_status rmap_suspension_scatter(const struct rmap_suspension *its, double wavelength,
                                         double n, double k, size_t n_angle, const double *cosine,
                                         double *intensity, struct rmap_suspended *suspended,
                                         struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const int n_size = its->sigma > 1.0 ? SIZES : 1;
    const double step = (reach + most_of(its)) / (SIZES - 1);
    double total = 0.0, *one = rmap_alloc(n_angle + 1, sizeof *one);
    struct rmap_mie *sum = &suspended->mie;
    *suspended = (struct rmap_suspended){.area = 0.0};
    if (!one)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for spheres"));
    for (size_t a = 0; a < n_angle; a++)
        intensity[a] = 0.0;
    for (int i = 0; i < n_size; i++) {
        const double t = n_size > 1 ? i * step - reach : 0.0, d = size_at(its, t),
                     share = rmap_portable_exp(-0.5 * t * t), area = 0.25 * RMAP_PI * d * d;
        struct rmap_mie mie;
        RMAP_TRY(rmap_mie_scatter(RMAP_PI * d / wavelength, n, k, n_angle, cosine, one, &mie, err));
        total += share;
        suspended->area += share * area;
        suspended->volume += share * area * d / 1.5;
        sum->extinct += share * area * mie.extinct;
        sum->scattered += share * area * mie.scattered;
        sum->back += share * area * mie.back;
        sum->cosine += share * area * mie.scattered * mie.cosine;
        for (size_t a = 0; a < n_angle; a++)
            intensity[a] += share * one[a];
    }
    sum->cosine /= sum->scattered;
    sum->extinct /= suspended->area;
    sum->scattered /= suspended->area;
    sum->back /= suspended->area;
    suspended->area /= total;
    suspended->volume /= total;
out:
    rmap_free(one);
    return st;
}
