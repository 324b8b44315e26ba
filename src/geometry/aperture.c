/* SPDX-License-Identifier: MIT
 *
 * Where a surface over a plane ends.
 */
#include "geometry/aperture.h"

#include <stddef.h>

bool rmap_aperture_is_circle(const struct rmap_aperture *a)
{
    return !a->rectangle && a->half[0] == a->half[1] && a->at[0] == 0 && a->at[1] == 0;
}

bool rmap_aperture_same(const struct rmap_aperture *a, const struct rmap_aperture *b)
{
    bool same = a->rectangle == b->rectangle;
    for (int k = 0; k < 2; k++)
        same = same && a->half[k] == b->half[k] && a->at[k] == b->at[k];
    return same;
}

bool rmap_aperture_has(const struct rmap_aperture *a, double x, double y)
{
    x -= a->at[0];
    y -= a->at[1];
    double s = x * x + y * y;
    if (s < a->inner * a->inner)
        return false;
    if (a->rectangle)
        return fabs(x) <= a->half[0] && fabs(y) <= a->half[1];
    if (a->half[0] == a->half[1])
        return s <= a->half[0] * a->half[0];
    x /= a->half[0];
    y /= a->half[1];
    return x * x + y * y <= 1;
}

static bool clip_sides(double p, double d, double half, double t[2])
{
    if (d == 0)
        return fabs(p) <= half;
    double a = (-half - p) / d, b = (half - p) / d;
    t[0] = rmap_max(t[0], rmap_min(a, b));
    t[1] = rmap_min(t[1], rmap_max(a, b));
    return t[0] < t[1];
}

bool rmap_aperture_clip(const struct rmap_aperture *a, struct rmap_vec3 p, struct rmap_vec3 d,
                        double t[2])
{
    double px = p.x - a->at[0], py = p.y - a->at[1];
    if (a->rectangle)
        return clip_sides(px, d.x, a->half[0], t) && clip_sides(py, d.y, a->half[1], t);
    /* scaled, so that it is a circle */
    const double share = a->half[0] / a->half[1], radius = a->half[0];
    const double y = py * share, vy = d.y * share;
    const double square = d.x * d.x + vy * vy;
    if (square == 0)
        return px * px + y * y <= radius * radius && t[0] < t[1];
    /* about the point nearest to the middle, whose coordinates are small */
    const double middle = -(px * d.x + y * vy) / square;
    const double x0 = px + middle * d.x, y0 = y + middle * vy;
    const double rest = radius * radius - (x0 * x0 + y0 * y0);
    if (!(rest > 0))
        return false;
    const double half = sqrt(rest / square);
    t[0] = rmap_max(t[0], middle - half);
    t[1] = rmap_min(t[1], middle + half);
    return t[0] < t[1];
}

/* Around a rectangle in quarters, one a side, from the middle of +x. */
static void around(const struct rmap_aperture *a, double u, double *x, double *y)
{
    const double quarter = 4 * (u + 0.125);
    const double along = 2 * (quarter - floor(quarter)) - 1;
    const int side = (int)floor(quarter) & 3;
    static const int turn[4][4] = {{1, 0, 0, 1}, {0, -1, 1, 0}, {-1, 0, 0, -1}, {0, 1, -1, 0}};
    *x = a->half[0] * (turn[side][0] + turn[side][1] * along);
    *y = a->half[1] * (turn[side][2] + turn[side][3] * along);
}

struct rmap_vec3 rmap_aperture_chart(const struct rmap_aperture *a, double u, double v)
{
    double x = a->half[0] * cos(2 * RMAP_PI * u), y = a->half[1] * sin(2 * RMAP_PI * u);
    if (a->rectangle)
        around(a, u, &x, &y);
    const double hole = a->inner / hypot(x, y);
    return rmap_vec3(a->at[0] + x * (1 - v + v * hole), a->at[1] + y * (1 - v + v * hole), 0);
}

void rmap_aperture_find(const struct rmap_aperture *a, double x, double y, double *u, double *v)
{
    double sx = (x - a->at[0]) / a->half[0], sy = (y - a->at[1]) / a->half[1];
    double share = sqrt(sx * sx + sy * sy);
    *u = atan2(sy, sx) / (2 * RMAP_PI);
    if (a->rectangle) {
        share = rmap_max(fabs(sx), fabs(sy));
        const int side = fabs(sx) >= fabs(sy) ? (sx < 0 ? 2 : 0) : (sy < 0 ? 3 : 1);
        const double along = side == 0 ? sy : side == 1 ? -sx : side == 2 ? -sy : sx;
        *u = 0.25 * (side + 0.5 * (share > 0 ? along / share : 0));
    }
    *u -= floor(*u);
    const double rim = share > 0 ? hypot(x - a->at[0], y - a->at[1]) / share : a->half[0];
    *v = (1 - share) / (1 - a->inner / rim);
}

struct rmap_vec3 rmap_aperture_outward(const struct rmap_aperture *a, double x, double y)
{
    x -= a->at[0];
    y -= a->at[1];
    if (a->rectangle)
        return fabs(x) - a->half[0] >= fabs(y) - a->half[1] ? rmap_vec3(x < 0 ? -1 : 1, 0, 0)
                                                            : rmap_vec3(0, y < 0 ? -1 : 1, 0);
    const double share = a->half[0] / a->half[1];
    return rmap_normalize(rmap_vec3(x, y * share * share, 0));
}

double rmap_aperture_near(const struct rmap_aperture *a)
{
    return a->at[0] == 0 && a->at[1] == 0 ? rmap_min(a->half[0], a->half[1]) : 0;
}

double rmap_aperture_far(const struct rmap_aperture *a)
{
    if (rmap_aperture_is_circle(a))
        return a->half[0];
    if (a->rectangle)
        return hypot(fabs(a->at[0]) + a->half[0], fabs(a->at[1]) + a->half[1]);
    return hypot(a->at[0], a->at[1]) + rmap_max(a->half[0], a->half[1]);
}

const char *rmap_aperture_check(const struct rmap_aperture *a)
{
    if (!(a->half[0] > 0 && a->half[1] > 0 && isfinite(a->half[0]) && isfinite(a->half[1])))
        return "aperture must be > 0 and finite";
    if (!(a->inner >= 0 && a->inner < rmap_min(a->half[0], a->half[1])))
        return "inner must be >= 0 and smaller than the aperture";
    return isfinite(a->at[0]) && isfinite(a->at[1]) ? NULL : "the aperture's place must be finite";
}
