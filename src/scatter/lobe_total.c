/* SPDX-License-Identifier: MIT
 *
 * How much a lobe scatters, by quadrature over the hemisphere, and tables of that over the angle of
 * incidence.
 */
#include <string.h>

#include "base/alloc.h"
#include "base/portable.h"
#include "formula/azimuth.h"
#include "scatter/dust.h"
#include "scatter/lobe.h"
#include "scatter/table.h"

/* Gauss and Legendre, 8 points of (-1, 1). */
enum { POINTS = 8, PANELS = 40, TURNS = 3 };
static const double node[POINTS / 2] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                        0.9602898564975363};
static const double weight[POINTS / 2] = {0.3626837833783620, 0.3137066458778873,
                                          0.2223810344533745, 0.1012285362903763};

/* Point i of the panel [from, to], and its weight. */
static double point(double from, double to, int i, double *w)
{
    int k = i / 2;
    *w = 0.5 * (to - from) * weight[k];
    return 0.5 * (from + to) + 0.5 * (to - from) * (i % 2 ? node[k] : -node[k]);
}

/* Cosine over the part of the circle about beta0 that lies above the horizon: its half from the
 * edge, at `arc`, to the far side. The square root at the edge wants a square. */
static double arc_cosine(double b, double x, double arc)
{
    double sum = 0.0, w, c, s;
    double far = arc > 0.0 ? sqrt(arc) : 0.0;
    for (int p = 0; p < TURNS; p++)
        for (int i = 0; i < POINTS; i++) {
            double v = point(far * p / TURNS, far * (p + 1) / TURNS, i, &w);
            double back = arc - v * v; /* from the far side, where light is steepest */
            rmap_azimuth(back / (2.0 * RMAP_PI), &c, &s);
            sum += w * 2.0 * v * rmap_lift(b * b + x * x - 2.0 * b * x * c);
        }
    return 2.0 * sum;
}

/* Azimuth of the circle that is above the horizon, or the integral of the cosine over it. */
static double around(const struct rmap_scattering *at, double b, double x)
{
    double arc = RMAP_PI;
    if (b * x > 0.0 && b + x > 1.0) {
        double c = (b * b + x * x - 1.0) / (2.0 * b * x);
        arc = c < 1.0 ? rmap_portable_angle(c, rmap_lift(c * c)) : 0.0;
    }
    return rmap_lobe_is_oblique(at) ? arc_cosine(b, x, arc) : 2.0 * arc;
}

/* Panels crowd towards 0, where the lobe is. */
static double panel(double to, int k)
{
    double part = (double)k / PANELS;
    return to * (part * part) * (part * part) * part;
}

double rmap_radial_total(const struct rmap_scattering *at)
{
    struct rmap_vec3 c = rmap_lobe_centre(at);
    double b = sqrt(c.x * c.x + c.y * c.y), sum = 0.0, w, cosine, sine;
    if (b < 1e-12)
        b = 0.0;
    for (int p = 0; p < PANELS; p++)
        for (int i = 0; i < POINTS; i++) {
            double g = point(panel(1.0, p), panel(1.0, p + 1), i, &w);
            double x = (1.0 - b) * g * (2.0 - g); /* a square root at the horizon, where b is 0 */
            sum += w * 2.0 * (1.0 - b) * (1.0 - g) * x * rmap_lobe_radial(at, x, true) *
                   around(at, b, x);
            if (b == 0.0)
                continue;
            /* from 1 - b to 1 + b by angle: square roots at both ends */
            double angle = point(panel(RMAP_PI, p), panel(RMAP_PI, p + 1), i, &w);
            rmap_azimuth(angle / (2.0 * RMAP_PI), &cosine, &sine);
            double half, other;
            rmap_azimuth(angle / (4.0 * RMAP_PI), &other, &half);
            x = (1.0 - b) + 2.0 * b * half * half;
            sum += w * b * sine * x * rmap_lobe_radial(at, x, true) * around(at, b, x);
        }
    return sum;
}

/* By the angle from the axis; around it, the positive part of a cosine in closed form. */
double rmap_cosine_total(const struct rmap_scattering *at)
{
    struct rmap_vec3 axis = rmap_lobe_axis(at);
    double power = rmap_lobe_number(at, RMAP_SHAPE_POWER), sum = 0.0, w, c, s;
    double up = fabs(axis.z), out = rmap_lift(up * up);
    double horizon = rmap_portable_angle(out, up); /* from the axis to the nearest point of it */
    for (int half = 0; half < 2; half++)
        for (int p = 0; p < PANELS; p++)
            for (int i = 0; i < POINTS; i++) {
                double span = half ? 0.5 * RMAP_PI - horizon : horizon;
                double angle =
                    (half ? horizon : 0.0) + point(panel(span, p), panel(span, p + 1), i, &w);
                rmap_azimuth(angle / (2.0 * RMAP_PI), &c, &s);
                double level = c * up, swing = s * out, ring = 2.0 * RMAP_PI * level;
                if (swing > level) {
                    double t = -level / swing, arc = rmap_portable_angle(t, rmap_lift(t * t));
                    ring = 2.0 * (level * arc + swing * rmap_lift(t * t));
                }
                sum += w * rmap_portable_power(c > 0.0 ? c : 0.0, power) * s * ring;
            }
    return sum;
}

/* Of facets only UNIFIED's totals are tabulated, which feel the media where light refracts. */
static bool is_of_media(const struct rmap_scatter *scatter)
{
    return scatter->refracts || scatter->by_roughness;
}

enum rmap_status rmap_scatter_tabulate(struct rmap_scatter *scatter, int n_channel, int32_t near,
                                       int32_t far, const double *n1, const double *n2,
                                       struct rmap_error *err)
{
    if ((rmap_scatter_is_facets(scatter) && scatter->model != RMAP_SCATTER_UNIFIED) ||
        scatter->model == RMAP_SCATTER_CONTAMINATION || rmap_scatter_is_table(scatter))
        return RMAP_OK;
    if (!is_of_media(scatter))
        near = far = -1;
    for (size_t i = 0; i < scatter->n_totals; i++)
        if (scatter->totals[i].near == near && scatter->totals[i].far == far)
            return RMAP_OK;
    const size_t n = RMAP_TOTAL_STEPS + 1, n_way = scatter->refracts ? 2 : 1;
    struct rmap_scatter_totals *more =
        rmap_realloc(scatter->totals, scatter->n_totals + 1, sizeof *more);
    if (!more)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scatter model");
    scatter->totals = more;
    struct rmap_scatter_totals *its = &more[scatter->n_totals];
    *its = (struct rmap_scatter_totals){near, far, n_channel, NULL};
    its->at = rmap_alloc(n_way * (size_t)n_channel * n, sizeof *its->at);
    if (!its->at)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scatter model");
    scatter->n_totals++;
    for (size_t way = 0; way < n_way; way++)
        for (int c = 0; c < n_channel; c++) {
            double *total = its->at + (way * (size_t)n_channel + (size_t)c) * n;
            bool again =
                c > 0 && !scatter->by_wavelength && n1[c] == n1[c - 1] && n2[c] == n2[c - 1];
            struct rmap_scattering at = {
                .scatter = scatter, .channel = c, .passes = way == 1, .n1 = n1[c], .n2 = n2[c]};
            struct rmap_vec3 in[RMAP_TOTAL_STEPS + 1];
            for (size_t k = 0; k < n; k++) {
                double v = (double)k / RMAP_TOTAL_STEPS, cosine = v * v;
                in[k] = rmap_vec3(rmap_lift(cosine * cosine), 0.0, -cosine);
            }
            if (again)
                memcpy(total, total - n, n * sizeof *total);
            else if (scatter->model == RMAP_SCATTER_UNIFIED)
                rmap_facet_fit(&at, n, in, total);
            else
                for (size_t k = 0; k < n; k++) {
                    at.in = in[k];
                    total[k] = rmap_lobe_total(&at);
                }
        }
    return RMAP_OK;
}

/* The cubic through four neighbours. */
static double interpolate(const double *value, double where)
{
    int k = (int)where;
    k = k < 1 ? 1 : k > RMAP_TOTAL_STEPS - 2 ? RMAP_TOTAL_STEPS - 2 : k;
    double t = where - k, a = value[k - 1], b = value[k], c = value[k + 1], d = value[k + 2];
    return b + t * ((c - a / 3.0 - b / 2.0 - d / 6.0) +
                    t * ((a + c) / 2.0 - b + t * ((b - c) / 2.0 + (d - a) / 6.0)));
}

double rmap_scatter_total(const struct rmap_scattering *at, int32_t near, int32_t far)
{
    const struct rmap_scatter *scatter = at->scatter;
    if (!is_of_media(scatter))
        near = far = -1;
    for (size_t i = 0; i < scatter->n_totals; i++)
        if (scatter->totals[i].near == near && scatter->totals[i].far == far) {
            const size_t row =
                (size_t)at->channel + (at->passes ? (size_t)scatter->totals[i].n_channel : 0);
            return interpolate(scatter->totals[i].at + row * (RMAP_TOTAL_STEPS + 1),
                               RMAP_TOTAL_STEPS * sqrt(at->in.z < 0.0 ? -at->in.z : 0.0));
        }
    return rmap_lobe_total(at);
}

void rmap_scatter_fini(struct rmap_scatter *scatter)
{
    for (size_t i = 0; i < scatter->n_totals; i++)
        rmap_free(scatter->totals[i].at);
    rmap_free(scatter->totals);
    rmap_scatter_table_destroy(scatter->table);
    rmap_scatter_dust_destroy(scatter->dust);
    *scatter = (struct rmap_scatter){.totals = NULL};
}
