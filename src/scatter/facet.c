/* SPDX-License-Identifier: MIT
 *
 * Rough surfaces of facets, each a smooth boundary. Light scatters once: what meets a second facet
 * is lost, and said (rmap_facet_total).
 */
#include <math.h>

#include "base/portable.h"
#include "formula/azimuth.h"
#include "scatter/scatter.h"

static double shape_of(const struct rmap_scattering *at, int k)
{
    return at->scatter->shape[k][at->channel];
}

static bool is_unified(const struct rmap_scattering *at)
{
    return at->scatter->model == RMAP_SCATTER_UNIFIED;
}

static bool is_ggx(const struct rmap_scattering *at)
{
    return at->scatter->model == RMAP_SCATTER_GGX;
}

/* Slopes are even within a circle, an ellipse where it is stretched. */
static bool is_pillbox(const struct rmap_scattering *at)
{
    return at->scatter->model == RMAP_SCATTER_SLOPE_ERROR && shape_of(at, RMAP_SHAPE_PILLBOX) > 0.0;
}

static struct rmap_vec3 towards_light(const struct rmap_scattering *at)
{
    return rmap_scale(at->in, -1.0);
}

static double square(double x)
{
    return x * x;
}

/* Facets' normals per solid angle and area of the surface; of UNIFIED not normalised. */
static double facets(const struct rmap_scattering *at, struct rmap_vec3 m)
{
    if (!(m.z > 0.0))
        return 0.0;
    if (is_unified(at)) {
        double angle = rmap_portable_angle(m.z, sqrt(m.x * m.x + m.y * m.y));
        return rmap_portable_exp(-0.5 * square(angle / shape_of(at, RMAP_SHAPE_SIGMA)));
    }
    double ax = shape_of(at, RMAP_SHAPE_ALPHA_X), ay = shape_of(at, RMAP_SHAPE_ALPHA_Y);
    double tilt = square(m.x / ax) + square(m.y / ay), z2 = m.z * m.z;
    if (is_pillbox(at))
        return tilt > z2 ? 0.0 : 1.0 / (RMAP_PI * ax * ay * z2 * z2);
    return is_ggx(at) ? 1.0 / (RMAP_PI * ax * ay * square(tilt + z2))
                      : rmap_portable_exp(-tilt / z2) / (RMAP_PI * ax * ay * z2 * z2);
}

/* 1 - erf(x), x >= 0, by a series of positive terms. */
static double erfc_of(double x)
{
    if (!(x < 6.0))
        return 0.0;
    double term = x, sum = x;
    for (int n = 1; term > 1e-18 * sum; n++) {
        term *= 2.0 * x * x / (double)(2 * n + 1);
        sum += term;
    }
    double left = 1.0 - 1.12837916709551257390 * rmap_portable_exp(-x * x) * sum;
    return left > 0.0 ? left : 0.0;
}

/* Integral of (q / h - 1) 2 sqrt(1 - q^2) / pi over q from h to 1. */
static double pillbox_hidden(double h)
{
    double root = sqrt(1.0 - h * h);
    double left =
        2.0 / RMAP_PI *
        (root * root * root / (3.0 * h) - 0.5 * (rmap_portable_angle(h, root) - h * root));
    return left > 0.0 ? left : 0.0;
}

/* Smith's auxiliary function of a direction: 1 / (1 + it) of its facets are seen from there (Heitz
 * 2014, JCGT 3 (2) 32). Portable where events are drawn by it. */
static double hidden(const struct rmap_scattering *at, struct rmap_vec3 w, bool portable)
{
    double reach = square(shape_of(at, RMAP_SHAPE_ALPHA_X) * w.x) +
                   square(shape_of(at, RMAP_SHAPE_ALPHA_Y) * w.y);
    double slope2 = w.z * w.z > 0.0 ? reach / (w.z * w.z) : 1e30;
    if (is_ggx(at))
        return 0.5 * (sqrt(1.0 + slope2) - 1.0);
    if (!(slope2 > 0.0))
        return 0.0;
    double h = 1.0 / sqrt(slope2);
    if (is_pillbox(at)) /* of a circle's chords, 2 sqrt(1 - q^2) / pi, those with q > h */
        return h < 1.0 ? pillbox_hidden(h) : 0.0;
    double left = portable
                      ? rmap_portable_exp(-h * h) * 0.28209479177387814347 / h - 0.5 * erfc_of(h)
                      : exp(-h * h) * 0.28209479177387814347 / h - 0.5 * erfc(h);
    return left > 0.0 ? left : 0.0;
}

double rmap_facet_unhindered(const struct rmap_scattering *at, struct rmap_vec3 out)
{
    if (is_unified(at))
        return 1.0;
    double there = hidden(at, out, true), here = hidden(at, at->in, true);
    return out.z > 0.0 ? (1.0 + here) / (1.0 + here + there) : 1.0 / (1.0 + there);
}

struct rmap_vec3 rmap_facet_reflected(struct rmap_vec3 in, struct rmap_vec3 normal)
{
    return rmap_normalize(rmap_axpy(-2.0 * rmap_dot(in, normal), normal, in));
}

bool rmap_facet_refracted(const struct rmap_scattering *at, struct rmap_vec3 normal,
                          struct rmap_vec3 *out)
{
    double cosine = rmap_dot(at->in, normal);
    struct rmap_vec3 tangent = rmap_scale(rmap_axpy(-cosine, normal, at->in), at->n1 / at->n2);
    double rest = 1.0 - rmap_dot(tangent, tangent);
    if (!(rest > 0.0))
        return false;
    *out = rmap_normalize(rmap_axpy(-sqrt(rest), normal, tangent));
    return true;
}

/* ---- draws ---- */

static void draw_numbers(const struct rmap_draw *draw, int k, double u[4])
{
    rmap_rng(draw->seed, draw->ray, draw->step, (enum rmap_rng_slot)(RMAP_RNG_LOBE + k), u);
}

/* The surface stretched to roughness 1, and a normal of it brought back. */
static struct rmap_vec3 stretched(const struct rmap_scattering *at)
{
    struct rmap_vec3 w = towards_light(at);
    return rmap_normalize(rmap_vec3(shape_of(at, RMAP_SHAPE_ALPHA_X) * w.x,
                                    shape_of(at, RMAP_SHAPE_ALPHA_Y) * w.y, w.z));
}

static struct rmap_vec3 back(const struct rmap_scattering *at, struct rmap_vec3 m)
{
    return rmap_normalize(rmap_vec3(shape_of(at, RMAP_SHAPE_ALPHA_X) * m.x,
                                    shape_of(at, RMAP_SHAPE_ALPHA_Y) * m.y, m.z > 0.0 ? m.z : 0.0));
}

/* Its tangent, of length 1 (any where it has none), and the one across. */
static struct rmap_vec3 tangent_of(struct rmap_vec3 w, struct rmap_vec3 *across)
{
    double length = sqrt(w.x * w.x + w.y * w.y);
    struct rmap_vec3 along =
        length > 0.0 ? rmap_vec3(w.x / length, w.y / length, 0.0) : rmap_vec3(1.0, 0.0, 0.0);
    *across = rmap_vec3(-along.y, along.x, 0.0);
    return along;
}

/* Heitz 2018: the visible half of a sphere, seen as a disc of which a part is hidden. */
static struct rmap_vec3 draw_ggx(const struct rmap_scattering *at, const struct rmap_draw *draw)
{
    struct rmap_vec3 view = stretched(at), x, y;
    double u[4], cosine, sine;
    (void)tangent_of(view, &x);
    y = rmap_cross(view, x);
    draw_numbers(draw, 0, u);
    rmap_azimuth(u[1], &cosine, &sine);
    double r = sqrt(u[0]), p = r * cosine, s = 0.5 * (1.0 + view.z);
    double q = (1.0 - s) * sqrt(1.0 - p * p) + s * r * sine, rest = 1.0 - p * p - q * q;
    struct rmap_vec3 m =
        rmap_axpy(p, x, rmap_axpy(q, y, rmap_scale(view, rest > 0.0 ? sqrt(rest) : 0.0)));
    return back(at, m);
}

/* Normal slopes, weighed by the area that is seen: c + s q where that is positive, q the slope
 * towards the light. Drawn from c + s max(q, 0), and what is too much given back. */
static struct rmap_vec3 draw_beckmann(const struct rmap_scattering *at,
                                      const struct rmap_draw *draw)
{
    struct rmap_vec3 view = stretched(at), across, along = tangent_of(view, &across);
    double c = view.z, s = sqrt(view.x * view.x + view.y * view.y);
    double steep = s * 0.28209479177387814347; /* s / (2 sqrt(pi)): mean of s max(q, 0) */
    double u[4], cosine, sine, q = 0.0, r = 0.0;
    for (int k = 0; k < RMAP_TRIES_MAX; k++) {
        draw_numbers(draw, k, u);
        double size = sqrt(-rmap_portable_log(u[1]));
        rmap_azimuth(u[2], &cosine, &sine);
        r = size * sine;
        if (u[0] * (c + steep) >= c) {
            q = sqrt(-rmap_portable_log(u[3]));
            break;
        }
        q = size * cosine;
        if (q >= 0.0 || u[3] * c < c + s * q)
            break;
    }
    struct rmap_vec3 m = rmap_axpy(q, along, rmap_scale(across, r));
    m.z = 1.0;
    return back(at, m);
}

/* The same of slopes within a circle, drawn again unless they are seen. */
static struct rmap_vec3 draw_pillbox(const struct rmap_scattering *at, const struct rmap_draw *draw)
{
    struct rmap_vec3 view = stretched(at), across, along = tangent_of(view, &across);
    double c = view.z, s = sqrt(view.x * view.x + view.y * view.y);
    double u[4], cosine, sine, q = 0.0, r = 0.0;
    for (int k = 0; k < RMAP_TRIES_MAX; k++) {
        draw_numbers(draw, k, u);
        rmap_azimuth(u[2], &cosine, &sine);
        q = sqrt(u[1]) * cosine;
        r = sqrt(u[1]) * sine;
        if (u[0] * (c + s) < c + s * q)
            break;
    }
    struct rmap_vec3 m = rmap_axpy(q, along, rmap_scale(across, r));
    m.z = 1.0;
    return back(at, m);
}

/* Does light meet the facet, and go to the right side of the surface from it? */
static bool fits(const struct rmap_scattering *at, struct rmap_vec3 m)
{
    struct rmap_vec3 out;
    if (!(rmap_dot(at->in, m) < 0.0) || !(rmap_facet_reflected(at->in, m).z > 0.0))
        return false;
    return !at->scatter->refracts || !rmap_facet_refracted(at, m, &out) || out.z < 0.0;
}

static struct rmap_vec3 draw_unified(const struct rmap_scattering *at, const struct rmap_draw *draw)
{
    double sigma = shape_of(at, RMAP_SHAPE_SIGMA), u[4], cosine, sine, c, s;
    for (int k = 1; k < RMAP_TRIES_MAX; k++) { /* 0 is the choice of the part */
        draw_numbers(draw, k, u);
        double angle = sigma * sqrt(-2.0 * rmap_portable_log(u[0]));
        if (!(angle < 0.5 * RMAP_PI))
            continue;
        rmap_azimuth(angle / (2.0 * RMAP_PI), &c, &s);
        rmap_azimuth(u[1], &cosine, &sine);
        struct rmap_vec3 m = rmap_vec3(s * cosine, s * sine, c);
        if (u[2] * angle < s && fits(at, m))
            return m;
    }
    return rmap_vec3(0.0, 0.0, 1.0);
}

struct rmap_vec3 rmap_facet_draw(const struct rmap_scattering *at, const struct rmap_draw *draw)
{
    if (is_unified(at))
        return draw_unified(at, draw);
    if (is_pillbox(at))
        return draw_pillbox(at, draw);
    return is_ggx(at) ? draw_ggx(at, draw) : draw_beckmann(at, draw);
}

/* ---- the BSDF ---- */

double rmap_facet_bsdf(const struct rmap_scattering *at, struct rmap_vec3 out, double *cos_ret)
{
    struct rmap_vec3 light = towards_light(at), m;
    bool reflects = out.z > 0.0;
    *cos_ret = 0.0;
    if (!(light.z > 0.0) || out.z == 0.0 || (!reflects && at->n1 == at->n2))
        return 0.0;
    m = reflects ? rmap_add(light, out) : rmap_axpy(at->n1, light, rmap_scale(out, at->n2));
    m = rmap_normalize(m.z < 0.0 ? rmap_scale(m, -1.0) : m);
    double cosine = rmap_dot(light, m), leaving = rmap_dot(out, m), per_direction;
    if (!(cosine > 0.0) || (leaving > 0.0) != reflects || (is_unified(at) && !fits(at, m)))
        return 0.0;
    *cos_ret = cosine < 1.0 ? cosine : 1.0;
    if (reflects)
        per_direction = 1.0 / (4.0 * cosine);
    else
        per_direction = square(at->n2) * -leaving / square(at->n1 * cosine + at->n2 * leaving);
    double density = facets(at, m) * per_direction / fabs(out.z);
    if (is_unified(at))
        return density / at->total;
    double here = hidden(at, at->in, false), there = hidden(at, out, false);
    double seen = reflects ? 1.0 / (1.0 + here + there) : 1.0 / ((1.0 + here) * (1.0 + there));
    return density * cosine * seen / light.z;
}

/* ---- totals ---- */

/* Of the tilt, by equal parts of the facets, or of the angle; around by equal turns. */
enum { TILTS = 160, TURNS = 96 };

/* A facet at these parts in (0, 1), and its weight in an integral over solid angle. */
static struct rmap_vec3 facet_at(const struct rmap_scattering *at, double part, double turn,
                                 double *weight)
{
    double cosine, sine, c, s;
    rmap_azimuth(turn, &cosine, &sine);
    if (is_unified(at)) {
        double most = 8.0 * shape_of(at, RMAP_SHAPE_SIGMA);
        most = most < 0.5 * RMAP_PI ? most : 0.5 * RMAP_PI;
        rmap_azimuth(part * most / (2.0 * RMAP_PI), &c, &s);
        struct rmap_vec3 m = {s * cosine, s * sine, c};
        *weight = 2.0 * RMAP_PI * most * s * facets(at, m);
        return m;
    }
    double left = (1.0 - part) * (1.0 - part); /* steep ones count much */
    double tan2 = is_pillbox(at) ? 1.0 - left
                  : is_ggx(at)   ? 1.0 / left - 1.0
                                 : -rmap_portable_log(left);
    double tangent = sqrt(tan2);
    struct rmap_vec3 m =
        rmap_normalize(rmap_vec3(shape_of(at, RMAP_SHAPE_ALPHA_X) * tangent * cosine,
                                 shape_of(at, RMAP_SHAPE_ALPHA_Y) * tangent * sine, 1.0));
    *weight = 2.0 * (1.0 - part) / m.z; /* facets per area are drawn by the area that they cover */
    return m;
}

void rmap_facet_fit(const struct rmap_scattering *at, size_t n, const struct rmap_vec3 *in,
                    double *fit)
{
    struct rmap_scattering by = *at;
    double weight;
    for (size_t j = 0; j < n; j++)
        fit[j] = 0.0;
    for (int i = 0; i < TILTS; i++)
        for (int k = 0; k < TURNS; k++) {
            struct rmap_vec3 m = facet_at(at, (i + 0.5) / TILTS, (k + 0.5) / TURNS, &weight);
            for (size_t j = 0; j < n; j++) {
                by.in = in[j];
                fit[j] += fits(&by, m) ? weight : 0.0;
            }
        }
    for (size_t j = 0; j < n; j++)
        fit[j] /= TILTS * TURNS;
}

void rmap_facet_total(const struct rmap_scattering *at,
                      void (*shares)(const void *self, double cosine, double share[2]),
                      const void *self, double total[3])
{
    double sum[2] = {0.0, 0.0}, all = 0.0, sent = 0.0, weight, share[2];
    for (int i = 0; i < TILTS; i++)
        for (int k = 0; k < TURNS; k++) {
            struct rmap_vec3 out, m = facet_at(at, (i + 0.5) / TILTS, (k + 0.5) / TURNS, &weight);
            double cosine = -rmap_dot(at->in, m);
            if (!(cosine > 0.0) || (is_unified(at) && !fits(at, m)))
                continue;
            weight *= is_unified(at) ? 1.0 : cosine;
            all += weight;
            shares(self, cosine < 1.0 ? cosine : 1.0, share);
            sent += weight * (share[0] + share[1]);
            out = rmap_facet_reflected(at->in, m);
            if (out.z > 0.0)
                sum[0] += weight * share[0] * rmap_facet_unhindered(at, out);
            if (share[1] > 0.0 && rmap_facet_refracted(at, m, &out) && out.z < 0.0)
                sum[1] += weight * share[1] * rmap_facet_unhindered(at, out);
        }
    total[0] = all > 0.0 ? sum[0] / all : 0.0;
    total[1] = all > 0.0 ? sum[1] / all : 0.0;
    total[2] = all > 0.0 ? (sent - sum[0] - sum[1]) / all : 0.0;
}
