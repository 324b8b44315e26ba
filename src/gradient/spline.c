/* SPDX-License-Identifier: MIT
 *
 * Interpolating cubic splines, C2 (de Boor 1978, A Practical Guide to Splines, ch.
 */
#include "gradient/spline.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"

static enum rmap_status check(const char *what, int n_point, const double *x, const double *y,
                              struct rmap_error *err)
{
    if (n_point < 2)
        return rmap_error_set(err, RMAP_INPUT, "%s: %d point(s); give at least 2", what, n_point);
    for (int i = 0; i < n_point; i++) {
        if (!isfinite(x[i]) || !isfinite(y[i]))
            return rmap_error_set(err, RMAP_INPUT, "%s: point %d is (%g, %g); give finite numbers",
                                  what, i + 1, x[i], y[i]);
        if (i > 0 && !(x[i] > x[i - 1]))
            return rmap_error_set(err, RMAP_INPUT,
                                  "%s: point %d is at %g, after %g; give them in increasing order",
                                  what, i + 1, x[i], x[i - 1]);
    }
    return RMAP_OK;
}

/* The tridiagonal system of the second derivatives m,
 *   d[i-1] m[i-1] + 2 (d[i-1] + d[i]) m[i] + d[i] m[i+1] = 6 (slope[i] - slope[i-1]),
 * m = 0 at natural ends, by elimination. over: scratch, [n_point]. */
static void solve(struct rmap_spline *spline, enum rmap_spline_start start, double *over)
{
    const double *x = spline->x, *y = spline->y;
    double *m = spline->second;
    int last = spline->n_point - 1;
    over[0] = m[0] = 0.0;
    if (start == RMAP_SPLINE_EVEN) {
        double d = x[1] - x[0];
        over[0] = 0.5;
        m[0] = 3.0 * (y[1] - y[0]) / (d * d);
    }
    for (int i = 1; i < last; i++) {
        double before = x[i] - x[i - 1], after = x[i + 1] - x[i];
        double bend = 6.0 * ((y[i + 1] - y[i]) / after - (y[i] - y[i - 1]) / before);
        double pivot = 2.0 * (before + after) - before * over[i - 1];
        over[i] = after / pivot;
        m[i] = (bend - before * m[i - 1]) / pivot;
    }
    m[last] = 0.0;
    for (int i = last - 1; i >= 0; i--)
        m[i] -= over[i] * m[i + 1];
}

enum rmap_status rmap_spline_init(struct rmap_spline *spline, const char *what, int n_point,
                                  const double *x, const double *y, enum rmap_spline_start start,
                                  struct rmap_error *err)
{
    enum rmap_status st = check(what, n_point, x, y, err);
    if (st != RMAP_OK)
        return st;
    size_t n = (size_t)n_point;
    double *block = rmap_alloc(n, 4 * sizeof(double));
    if (!block)
        return rmap_error_set(err, RMAP_SYSTEM, "%s: no memory for %d points", what, n_point);
    *spline = (struct rmap_spline){n_point, block, block + n, block + 2 * n};
    memcpy(spline->x, x, n * sizeof(double));
    memcpy(spline->y, y, n * sizeof(double));
    solve(spline, start, block + 3 * n);
    return RMAP_OK;
}

void rmap_spline_fini(struct rmap_spline *spline)
{
    rmap_free(spline->x);
    *spline = (struct rmap_spline){0};
}

/* The i with x[i] <= x < x[i + 1], at the ends the first or last piece. */
static int piece_of(const struct rmap_spline *spline, double x)
{
    int low = 0, high = spline->n_point - 1;
    while (high - low > 1) {
        int middle = low + (high - low) / 2;
        if (spline->x[middle] <= x)
            low = middle;
        else
            high = middle;
    }
    return low;
}

void rmap_spline_at(const struct rmap_spline *spline, double x, double f[3])
{
    const double *m = spline->second;
    double first = spline->x[0], last = spline->x[spline->n_point - 1];
    double inside = fmin(fmax(x, first), last);
    int i = piece_of(spline, inside);
    double d = spline->x[i + 1] - spline->x[i], t = inside - spline->x[i];
    double third = (m[i + 1] - m[i]) / d;
    double slope = (spline->y[i + 1] - spline->y[i]) / d - d * (2.0 * m[i] + m[i + 1]) / 6.0;
    f[0] = spline->y[i] + t * (slope + t * (0.5 * m[i] + t * third / 6.0));
    f[1] = slope + t * (m[i] + 0.5 * t * third);
    f[2] = m[i] + t * third;
    if (x == inside)
        return;
    f[0] += f[1] * (x - inside);
    f[2] = 0.0;
}
