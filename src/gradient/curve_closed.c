/* SPDX-License-Identifier: MIT
 *
 * Steps where n^2 is a polynomial of second degree: D is linear in r there, dD/dr = A, and
 *     r(t) = sum of X_k,   X_0 = r, X_1 = t T, X_2 = t^2/2 D, X_k+2 = t^2 / ((k+1) (k+2)) A X_k,
 * which are sines, hyperbolic sines and parabolas about the axes of A (Luneburg 1944, Mathematical
 * Theory of Optics, sec. 28; Ghatak, Thyagarajan 1978, Contemporary Optics, ch. 2). The series is
 * summed until rounding hides what is left.
 */
#include <float.h>

#include "gradient/curve_internal.h"

/* Longest step as an angle phi = omega t, omega^2 the norm of A: a little more than from one side
 * of Luneburg's sphere to the other. */
#define LONGEST 1.7

/* Dense output meets r, T and D at the start, r and T at the end, and r at five places between
 * them, which make the greatest value of w = s^2 (s - 1)^2 (s - s1) ... (s - s5) over [0, 1] least:
 * 1.665e-5; then its derivative's is 3.520e-4. r is off by w X_9 at most, with X_9 of the place
 * where it is greatest; T likewise. */
static const double node_polynomial[RMAP_CURVE_POWERS] = {-0.013457657263988522,
                                                          0.22390294960197762,
                                                          -1.4176498890500604,
                                                          4.5575661994421885,
                                                          -8.190506243822163,
                                                          8.340144641092046,
                                                          -4.5}; /* w / s^2, less s^7 */
static const double w_r = 1.665e-5, w_T = 3.520e-4, factorial_9 = 362880.0;

/* Allowed of T between the steps' ends, in tolerances, as an angle over the size. */
static const double loose = 10.0;

void rmap_curve_find_closed(struct rmap_curve *curve)
{
    const struct rmap_gradient *gradient = curve->gradient;
    double bend[3][3], square = 0.0;
    curve->closed = gradient->options.scheme == RMAP_SCHEME_ADAPTIVE &&
                    rmap_field_quadratic(gradient->field, curve->channel, bend);
    if (!curve->closed)
        return;
    rmap_affine_congruent(&gradient->to_local, bend);
    for (int j = 0; j < 3; j++) {
        square = rmap_max(square, fabs(bend[0][j]) + fabs(bend[1][j]) + fabs(bend[2][j]));
        for (int i = 0; i < 4; i++)
            curve->bend[j][i] = i < 3 ? bend[i][j] : 0.0;
    }
    /* X_9 <= phi^8 / 9! t |T|, and t |T| <= 2 size: see advance_closed() */
    double factor = 2.0 * rmap_max(w_r, w_T / loose) / factorial_9;
    double phi = sqrt(sqrt(sqrt(gradient->options.tolerance / gradient->size / factor)));
    curve->closed_h = rmap_min(phi, LONGEST) / sqrt(square); /* A = 0: infinite */
    curve->closed_norm = square;
    curve->closed_least = 1e-3 * gradient->options.tolerance / gradient->size;
}

/* 1 / (k (k - 1)) */
#define INVERSE(k)  1.0 / ((k) * ((k)-1))
#define INVERSES(k) INVERSE(k), INVERSE(k + 1), INVERSE(k + 2), INVERSE(k + 3)
static const double inverse[] = {INVERSES(2),  INVERSES(6),  INVERSES(10),
                                 INVERSES(14), INVERSES(18), INVERSES(22)};
enum { TERMS_MAX = sizeof inverse / sizeof inverse[0] - 1 };

/* X_2, X_3, ... at h, until rounding hides them. */
struct series {
    int n, n_dense; /* how many; of them those that dense output needs */
    rmap_wide term[TERMS_MAX];
};

static inline void multiply(const rmap_wide column[3], double factor, rmap_wide *a)
{
    rmap_wide scaled = *a * factor;
    *a = column[0] * scaled[0] + column[1] * scaled[1] + column[2] * scaled[2];
}

static inline void expand(const struct rmap_curve *curve, const struct rmap_curve_state *from,
                          double h, struct series *series)
{
    const double rounding = 1e-17;
    double square = h * h, phi2 = curve->closed_norm * square, share = phi2 * inverse[1];
    rmap_wide column[3], odd, even;
    int n = 1, n_dense = 1;
    for (int j = 0; j < 3; j++) {
        rmap_wide_load(&column[j], curve->bend[j]);
        column[j] = column[j] * square;
    }
    rmap_wide_set(&odd, from->T);
    odd = odd * h;
    rmap_wide_set(&even, from->D);
    even = even * (0.5 * square);
    series->term[0] = even;
    while (share > rounding && n + 2 <= TERMS_MAX) {
        multiply(column, inverse[n], &odd);
        multiply(column, inverse[n + 1], &even);
        series->term[n] = odd;
        series->term[n + 1] = even;
        n += 2;
        n_dense = share > curve->closed_least ? n : n_dense;
        share *= phi2 * inverse[n];
    }
    series->n = n;
    series->n_dense = n_dense;
}

/* Dense output from the series, which is left in disorder, and D in mid-step, for the greatest
 * bend: from there to the ends it grows by less than the bend's margin, 1 / cos(phi / 4). */
static inline void set_dense(struct rmap_curve_step *step, double h, struct series *series)
{
    rmap_wide *term = series->term, D = {0};
    double scale = 1.0 / (h * h);
    for (int k = series->n_dense - 1; k >= RMAP_CURVE_POWERS; k--)
        for (int i = 0; i < RMAP_CURVE_POWERS; i++)
            rmap_wide_axpy(-node_polynomial[i], &term[k], &term[k - RMAP_CURVE_POWERS + i]);
    for (int k = RMAP_CURVE_POWERS - 1; k >= 0; k--) {
        rmap_wide bend = {0};
        if (k < series->n)
            bend = term[k] * scale;
        rmap_curve_set_bend(step, k, &bend);
        D = D * 0.5 + bend * (double)((k + 1) * (k + 2));
    }
    rmap_wide_store(&D, step->D[1]);
    step->n_stage = 2;
}

RMAP_WIDE
bool rmap_curve_closed(struct rmap_curve *curve, struct rmap_curve_step *step, double h)
{
    const struct rmap_curve_state *from = &step->from;
    struct series series;
    rmap_wide r = {0}, T = {0}; /* what they grow by, the former less h T, the latter times h */
    expand(curve, from, h, &series);
    for (int k = series.n - 1; k >= 0; k--) {
        r = r + series.term[k];
        T = T + series.term[k] * (double)(k + 2);
    }
    step->to.r = rmap_add(from->r, rmap_axpy(h, from->T, rmap_wide_vec3(&r)));
    step->to.T = rmap_axpy(1.0 / h, rmap_wide_vec3(&T), from->T);
    if (!rmap_curve_evaluate(curve, &step->to))
        return false;
    set_dense(step, h, &series);
    step->h = step->whole = h;
    step->closed = true;
    step->pair = NULL;
    rmap_curve_measure(step);
    return true;
}
