/* SPDX-License-Identifier: MIT
 *
 * Aspheres and other sags. Along the ray s(t) = x^2 + y^2 is a quadratic and the surface is met
 * where
 *
 *     g(t) = z(t) - sag(s(t)) = 0, of a SAG z(t) - sag(x(t), y(t)) = 0.
 *
 * The part of the ray over the aperture is cut into intervals, first in ray order, until on each
 * of them g provably has no root (its range excludes 0) or at most one (the range of its
 * derivative does: interval Newton, Moore 1966, "Interval Analysis"). So no root is missed, at
 * grazing incidence either, and none is found out of order. Where the ray starts on the surface,
 * t = 0 is an end point of an interval and its root is known: an interval that touches it with g
 * monotonic has no other. Of a SAG the ranges follow from g and its slope in the middle m, of width
 * 2 h, and a bound M of its second derivative: |g(t) - g(m)| <= |g'(m)| h + M h^2 / 2.
 */
#include "geometry/shape_internal.h"

#include <float.h>

struct range {
    double lower, upper;
};

struct ray2 {
    struct rmap_vec3 p, d; /* shifted to the point nearest to the vertex */
    double s0, s1, s2;     /* s(t) = s0 + 2 s1 t + s2 t^2 */
    double turn, least;    /* SAG: where s is least, and what it is there */
};

double rmap_conic_sag(const struct rmap_shape *shape, double s)
{
    double c = shape->curvature;
    double z = c * s / (1 + sqrt(fmax(0, 1 - (1 + shape->conic) * c * c * s)));
    double poly = 0;
    for (int i = shape->n_asphere - 1; i >= 0; i--)
        poly = (poly + shape->asphere[i]) * s;
    return z + poly;
}

double rmap_conic_slope(const struct rmap_shape *shape, double s)
{
    double c = shape->curvature;
    double poly = 0;
    for (int i = shape->n_asphere - 1; i >= 0; i--)
        poly = poly * s + (i + 1) * shape->asphere[i];
    return c / (2 * sqrt(fmax(0, 1 - (1 + shape->conic) * c * c * s))) + poly;
}

/* Range of a polynomial part's monomial sum over [s.lower, s.upper], 0 <= s.lower. */
static struct range monomials(const struct rmap_shape *shape, struct range s, bool derivative)
{
    struct range sum = {0, 0};
    double low = derivative ? 1 : s.lower;
    double high = derivative ? 1 : s.upper;
    for (int i = 0; i < shape->n_asphere; i++) {
        double a = shape->asphere[i] * (derivative ? i + 1 : 1);
        sum.lower += a * (a > 0 ? low : high);
        sum.upper += a * (a > 0 ? high : low);
        low *= s.lower;
        high *= s.upper;
    }
    return sum;
}

static double conic_part(const struct rmap_shape *shape, double s, bool derivative)
{
    double c = shape->curvature;
    double root = sqrt(fmax(0, 1 - (1 + shape->conic) * c * c * s));
    return derivative ? c / (2 * root) : c * s / (1 + root);
}

/* Both parts of the conic are monotonic in s; the pad covers the rounding of the sums. */
static struct range sag_range(const struct rmap_shape *shape, struct range s, bool derivative)
{
    double a = conic_part(shape, s.lower, derivative);
    double b = conic_part(shape, s.upper, derivative);
    struct range m = monomials(shape, s, derivative);
    struct range r = {fmin(a, b) + m.lower, fmax(a, b) + m.upper};
    double pad =
        8 * DBL_EPSILON *
        (fabs(a) + fabs(b) + fabs(m.lower) + fabs(m.upper) + fabs(r.lower) + fabs(r.upper));
    return (struct range){r.lower - pad, r.upper + pad};
}

void rmap_asphere_sag_range(const struct rmap_shape *shape, double *lower, double *upper)
{
    enum { PIECES = 64 };
    double s0 = shape->inner * shape->inner;
    double step = (shape->aperture * shape->aperture - s0) / PIECES;
    *lower = INFINITY;
    *upper = -INFINITY;
    for (int i = 0; i < PIECES; i++) {
        struct range r = sag_range(
            shape,
            (struct range){s0 + i * step, i + 1 < PIECES ? s0 + (i + 1) * step
                                                         : shape->aperture * shape->aperture},
            false);
        *lower = fmin(*lower, r.lower);
        *upper = fmax(*upper, r.upper);
    }
}

static double s_at(const struct ray2 *ray, double t)
{
    double x = ray->p.x + t * ray->d.x;
    double y = ray->p.y + t * ray->d.y;
    return x * x + y * y;
}

static double g_at(const struct rmap_shape *shape, const struct ray2 *ray, double t)
{
    if (shape->type == RMAP_SHAPE_SAG) {
        const struct rmap_vec3 q = rmap_axpy(t, ray->d, ray->p);
        return q.z - rmap_sag_height(shape->sag[0], q.x, q.y).z;
    }
    return ray->p.z + t * ray->d.z - rmap_conic_sag(shape, s_at(ray, t));
}

static double g_slope(const struct rmap_shape *shape, const struct ray2 *ray, double t)
{
    if (shape->type == RMAP_SHAPE_SAG) {
        const struct rmap_vec3 q = rmap_axpy(t, ray->d, ray->p);
        const struct rmap_height at = rmap_sag_height(shape->sag[0], q.x, q.y);
        return ray->d.z - at.x * ray->d.x - at.y * ray->d.y;
    }
    return ray->d.z - 2 * rmap_conic_slope(shape, s_at(ray, t)) * (ray->s1 + t * ray->s2);
}

static struct range s_range(const struct rmap_shape *shape, const struct ray2 *ray, struct range t)
{
    double a = s_at(ray, t.lower);
    double b = s_at(ray, t.upper);
    double turn = ray->s2 > 0 ? -ray->s1 / ray->s2 : t.lower;
    struct range s = {fmin(a, b), fmax(a, b)};
    if (turn > t.lower && turn < t.upper)
        s.lower = fmin(s.lower, s_at(ray, turn));
    s.upper = fmin(s.upper, shape->aperture * shape->aperture);
    s.lower = fmin(s.lower, s.upper);
    return s;
}

static struct range product(struct range a, struct range b)
{
    double p[4] = {a.lower * b.lower, a.lower * b.upper, a.upper * b.lower, a.upper * b.upper};
    struct range r = {p[0], p[0]};
    for (int i = 1; i < 4; i++) {
        r.lower = fmin(r.lower, p[i]);
        r.upper = fmax(r.upper, p[i]);
    }
    return r;
}

static bool excludes_zero(struct range r)
{
    return r.lower > 0 || r.upper < 0;
}

/* At most one root between the ends: Newton, kept inside the bracket by bisection. */
static double refine(const struct rmap_shape *shape, const struct ray2 *ray, struct range t)
{
    double g_low = g_at(shape, ray, t.lower);
    double x = 0.5 * (t.lower + t.upper);
    double best = x;
    double g_best = INFINITY;
    for (int i = 0; i < 200; i++) {
        double g = g_at(shape, ray, x);
        if (fabs(g) < g_best) {
            g_best = fabs(g);
            best = x;
        } else if (i > 3 && t.upper - t.lower < 1e-9 * (fabs(t.upper) + fabs(t.lower))) {
            break;
        }
        if (g == 0)
            break;
        if ((g < 0) == (g_low < 0))
            t.lower = x;
        else
            t.upper = x;
        double next = x - g / g_slope(shape, ray, x);
        if (!(next > t.lower && next < t.upper))
            next = 0.5 * (t.lower + t.upper);
        if (fabs(next - x) <= 0.5 * DBL_EPSILON * fabs(x) || next == t.lower || next == t.upper) {
            best = fabs(g_at(shape, ray, next)) < g_best ? next : best;
            break;
        }
        x = next;
    }
    return best;
}

/* What an interval holds: nothing, at most one root, or it must be cut. */
enum outcome { EMPTY, MONOTONIC, UNCLEAR };

static enum outcome evaluate_sag(const struct rmap_shape *shape, const struct ray2 *ray,
                                 struct range t)
{
    const struct rmap_sag *sag = shape->sag[0];
    const double half = 0.5 * (t.upper - t.lower), a = s_at(ray, t.lower), b = s_at(ray, t.upper);
    const struct rmap_vec3 q = rmap_axpy(0.5 * (t.lower + t.upper), ray->d, ray->p);
    const struct rmap_height at = rmap_sag_height(sag, q.x, q.y);
    const double slope = ray->d.z - at.x * ray->d.x - at.y * ray->d.y;
    const bool turns = ray->turn > t.lower && ray->turn < t.upper;
    const double bend =
        rmap_sag_bend(sag, ray->d, ray->least, turns ? ray->least : rmap_min(a, b), rmap_max(a, b));
    const double rounding = 16 * DBL_EPSILON;
    const double pad = sag->noise + rounding * (fabs(at.z) + fabs(q.z));
    const double change = (fabs(slope) + 0.5 * bend * half) * half;
    if (fabs(q.z - at.z) > change + pad)
        return EMPTY;
    const double rest = rounding * (fabs(ray->d.z) + fabs(at.x * ray->d.x) + fabs(at.y * ray->d.y));
    /* where all of it is rounding there is nothing to be cut */
    return fabs(slope) > bend * half * (1 + 1e-9) + rest || change <= pad ? MONOTONIC : UNCLEAR;
}

static enum outcome evaluator(const struct rmap_shape *shape, const struct ray2 *ray,
                              struct range t)
{
    if (shape->type == RMAP_SHAPE_SAG)
        return evaluate_sag(shape, ray, t);
    struct range s = s_range(shape, ray, t);
    struct range sag = sag_range(shape, s, false);
    double z0 = ray->p.z + t.lower * ray->d.z;
    double z1 = ray->p.z + t.upper * ray->d.z;
    if (fmin(z0, z1) > sag.upper || fmax(z0, z1) < sag.lower)
        return EMPTY;
    struct range ds = {2 * (ray->s1 + t.lower * ray->s2), 2 * (ray->s1 + t.upper * ray->s2)};
    struct range slope = product(sag_range(shape, s, true), ds);
    struct range dg = {ray->d.z - slope.upper, ray->d.z - slope.lower};
    return excludes_zero(dg) ? MONOTONIC : UNCLEAR;
}

/* Part of the ray between two heights; false: none. */
static bool clip_heights(const struct ray2 *ray, struct range z, struct range *t)
{
    if (ray->d.z != 0) {
        double a = (z.lower - ray->p.z) / ray->d.z;
        double b = (z.upper - ray->p.z) / ray->d.z;
        double pad = 1e-9 * (fabs(b - a) + fabs(a)) + DBL_MIN;
        t->lower = fmax(t->lower, fmin(a, b) - pad);
        t->upper = fmin(t->upper, fmax(a, b) + pad);
    } else if (ray->p.z < z.lower || ray->p.z > z.upper) {
        return false;
    }
    return t->lower < t->upper;
}

static bool clip_sag(const struct rmap_shape *shape, const struct ray2 *ray, struct range *t)
{
    double part[2] = {t->lower, t->upper};
    if (!rmap_aperture_clip(&shape->outline, ray->p, ray->d, part))
        return false;
    *t = (struct range){part[0], part[1]};
    /* a ray that starts on it keeps its start */
    const double pad = 1e-9 * shape->sag[0]->far;
    return clip_heights(ray, (struct range){shape->sag[0]->low - pad, shape->sag[0]->high + pad},
                        t);
}

/* Part of the ray over the aperture and between the lowest and highest sag; false: none. */
static bool clip(const struct rmap_shape *shape, const struct ray2 *ray, struct range *t)
{
    if (shape->type == RMAP_SHAPE_SAG)
        return clip_sag(shape, ray, t);
    double excess = ray->s0 - shape->aperture * shape->aperture;
    if (ray->s2 > 0) {
        double discriminant = ray->s1 * ray->s1 - ray->s2 * excess;
        if (!(discriminant > 0))
            return false;
        double root = sqrt(discriminant);
        t->lower = fmax(t->lower, (-ray->s1 - root) / ray->s2);
        t->upper = fmin(t->upper, (-ray->s1 + root) / ray->s2);
    } else if (excess > 0) {
        return false;
    }
    struct range z = sag_range(shape, (struct range){0, shape->aperture * shape->aperture}, false);
    return clip_heights(ray, z, t);
}

static bool accept(const struct rmap_shape *shape, const struct ray2 *ray,
                   const struct rmap_shape_query *query, double t, double shift,
                   struct rmap_shape_hit *hit)
{
    struct rmap_vec3 q = rmap_axpy(t, ray->d, ray->p);
    double s = q.x * q.x + q.y * q.y;
    bool plain = shape->type == RMAP_SHAPE_SAG
                     ? rmap_aperture_has(&shape->outline, q.x, q.y)
                     : s <= shape->aperture * shape->aperture && s >= shape->inner * shape->inner;
    if (!(t + shift > query->t_min && t + shift < query->t_max) ||
        !rmap_root_belongs(query, t + shift, &q, plain))
        return false;
    hit->t = t + shift;
    hit->point = q;
    hit->normal = rmap_shape_normal(shape, q);
    hit->predicted = false; /* src/compact has another way to the root */
    return true;
}

/* Does the slope jump on the axis? */
static bool has_tip(const struct rmap_shape *shape)
{
    return shape->type == RMAP_SHAPE_SAG && shape->sag[0]->n_power > 0 &&
           shape->sag[0]->power[0] != 0;
}

/* First root in `t`; `known`: where a root stands that does not count (NaN: nowhere). */
static bool search(const struct rmap_shape *shape, const struct ray2 *ray,
                   const struct rmap_shape_query *query, struct range t, double known, double shift,
                   struct rmap_shape_hit *hit)
{
    enum { DEPTH = 56, CUTS = 1 << 14 }; /* cuts: a line may lie in a surface */
    int left = CUTS;
    struct range stack[DEPTH + 1];
    double smallest = (t.upper - t.lower) * 0x1p-50;
    int n = 0;
    if (has_tip(shape) && ray->turn > t.lower && ray->turn < t.upper) {
        stack[n++] = (struct range){ray->turn, t.upper};
        t.upper = ray->turn;
    }
    stack[n++] = t;
    while (n > 0) {
        struct range now = stack[--n];
        bool touches = now.lower == known || now.upper == known;
        enum outcome outcome = evaluator(shape, ray, now);
        if (outcome == EMPTY || (outcome == MONOTONIC && touches))
            continue;
        if (outcome == UNCLEAR && now.upper - now.lower > smallest && n + 2 <= DEPTH &&
            left-- > 0) {
            double middle = 0.5 * (now.lower + now.upper);
            stack[n++] = (struct range){middle, now.upper};
            stack[n++] = (struct range){now.lower, middle};
            continue;
        }
        double a = g_at(shape, ray, now.lower);
        double b = g_at(shape, ray, now.upper);
        if (touches || (a > 0 && b > 0) || (a < 0 && b < 0))
            continue;
        double root = a == 0 ? now.lower : b == 0 ? now.upper : refine(shape, ray, now);
        if (accept(shape, ray, query, root, shift, hit))
            return true;
    }
    return false;
}

/* A little beyond its rim, where another shape may share that. */
static struct rmap_shape widened(const struct rmap_shape *shape)
{
    struct rmap_shape wide = *shape;
    wide.aperture *= 1 + 1e-9;
    for (int k = 0; k < 2; k++)
        wide.outline.half[k] *= 1 + 1e-9;
    return wide;
}

/* A SAG that is flat, as a Fresnel surface is. */
static bool meet_plane(const struct rmap_shape *shape, const struct rmap_shape_query *query,
                       struct rmap_shape_hit *hit)
{
    const struct rmap_vec3 p = query->origin, d = query->direction;
    const double t = -p.z / d.z;
    struct rmap_vec3 at = rmap_vec3(p.x + t * d.x, p.y + t * d.y, 0);
    if (query->on_surface || d.z == 0 || !(t > query->t_min && t < query->t_max) ||
        !rmap_root_belongs(query, t, &at, rmap_aperture_has(&shape->outline, at.x, at.y)))
        return false;
    *hit = (struct rmap_shape_hit){t, at, rmap_shape_normal(shape, at), false};
    return true;
}

bool rmap_asphere_intersect(const struct rmap_shape *shape, const struct rmap_shape_query *query,
                            struct rmap_shape_hit *hit)
{
    struct rmap_shape wide;
    if (shape->type == RMAP_SHAPE_SAG && shape->sag[0]->flat)
        return meet_plane(shape, query, hit);
    if (query->joints) {
        wide = widened(shape);
        shape = &wide;
    }
    struct rmap_vec3 d = query->direction;
    double shift = query->on_surface ? 0 : -rmap_dot(query->origin, d) / rmap_dot(d, d);
    struct ray2 ray = {.p = rmap_axpy(shift, d, query->origin), .d = d};
    ray.s0 = ray.p.x * ray.p.x + ray.p.y * ray.p.y;
    ray.s1 = ray.p.x * d.x + ray.p.y * d.y;
    ray.s2 = d.x * d.x + d.y * d.y;
    ray.turn = ray.s2 > 0 ? -ray.s1 / ray.s2 : 0;
    ray.least = s_at(&ray, ray.turn);
    struct range t = {query->t_min - shift, query->t_max - shift};
    if (!clip(shape, &ray, &t))
        return false;
    if (!query->on_surface)
        return search(shape, &ray, query, t, NAN, shift, hit);
    if (t.lower < 0 &&
        search(shape, &ray, query, (struct range){t.lower, fmin(0, t.upper)}, 0, shift, hit))
        return true;
    return t.upper > 0 &&
           search(shape, &ray, query, (struct range){fmax(0, t.lower), t.upper}, 0, shift, hit);
}
