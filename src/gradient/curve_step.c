/* SPDX-License-Identifier: MIT
 *
 * What the curve's schemes share: one step each from the curve's state, and its dense output.
 */
#include <float.h>

#include "gradient/curve_pairs.h"
#include "gradient/curve_step.h"

/* Steps where n^2 is a polynomial of second degree: D is linear in r there, dD/dr = A, and
 *     r(t) = sum of X_k,   X_0 = r, X_1 = t T, X_2 = t^2/2 D, X_k+2 = t^2 / ((k+1) (k+2)) A X_k,
 * which are sines, hyperbolic sines and parabolas about the axes of A (Luneburg 1944, Mathematical
 * Theory of Optics, sec. 28; Ghatak, Thyagarajan 1978, Contemporary Optics, ch. 2). The series is
 * summed until rounding hides what is left. */

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

/* Steps of the Runge-Kutta-Nystroem pairs and their errors. */

/* sum + weight D. A coefficient of 0 costs nothing where it is known. */
RMAP_COPIED void add_stage(double weight, const double D[4], rmap_wide *sum)
{
    rmap_wide of;
    if (weight != 0.0) {
        rmap_wide_load(&of, D);
        rmap_wide_axpy(weight, &of, sum);
    }
}

/* Sum of the stages' D, weighted. */
RMAP_COPIED void combine(const double *weight, const struct rmap_curve_step *step, int count,
                         rmap_wide *sum)
{
    *sum = (rmap_wide){0};
    RMAP_UNROLL
    for (int i = 0; i < count; i++) {
        add_stage(weight[i], step->D[i], sum);
    }
}

static inline double square_of(const rmap_wide *a)
{
    return rmap_dot(rmap_wide_vec3(a), rmap_wide_vec3(a));
}

/* D = n grad n */
static inline bool evaluate(const struct rmap_curve *curve, const rmap_wide *r, double *n,
                            double D[4])
{
    struct rmap_vec3 slope;
    rmap_wide of;
    if (!rmap_gradient_at(curve->gradient, curve->channel, rmap_wide_vec3(r), n, &slope)) {
        return false;
    }
    rmap_wide_set(&of, slope);
    of = of * *n;
    rmap_wide_store(&of, D);
    return true;
}

RMAP_COPIED bool step_with(const struct rmap_curve_pair *pair, int stages, struct rmap_curve *curve,
                           struct rmap_curve_step *step, double h)
{
    rmap_wide from_r, from_T, r, sum;
    step->pair = pair;
    step->n_stage = stages;
    rmap_wide_set(&from_r, step->from.r);
    rmap_wide_set(&from_T, step->from.T);
    rmap_wide_set(&r, step->from.D);
    rmap_wide_store(&r, step->D[0]);
    RMAP_UNROLL
    for (int i = 1; i < stages; i++) {
        combine(pair->coupling[i], step, i, &sum);
        r = from_r;
        rmap_wide_axpy(pair->node[i] * h, &from_T, &r);
        rmap_wide_axpy(h * h, &sum, &r);
        if (!evaluate(curve, &r, &step->to.n, step->D[i])) {
            curve->n_evaluation += (uint64_t)i;
            return false;
        }
    }
    curve->n_evaluation += (uint64_t)pair->evaluations;
    combine(pair->weight_T, step, stages, &sum);
    rmap_wide_axpy(h, &sum, &from_T);
    step->to.r = rmap_wide_vec3(&r);
    step->to.T = rmap_wide_vec3(&from_T);
    const double *D = step->D[stages - 1];
    step->to.D = rmap_vec3(D[0], D[1], D[2]);
    return true;
}

RMAP_WIDE
bool rmap_curve_nystrom(struct rmap_curve *curve, const struct rmap_curve_pair *pair,
                        struct rmap_curve_step *step, double h)
{
    step->h = step->whole = h;
    return pair == &rmap_curve_pair_8 ? step_with(&rmap_curve_pair_8, 9, curve, step, h)
                                      : step_with(&rmap_curve_pair_6, 6, curve, step, h);
}

/* Squares: h times the error of r, the error of T, and what is two and four orders rougher. */
struct defects {
    double place, turn, rough, rougher;
};

RMAP_COPIED struct defects defects_with(const struct rmap_curve_pair *pair, int stages,
                                        const struct rmap_curve_step *step)
{
    rmap_wide of_r, of_T, of_rough, of_rougher;
    combine(pair->defect_r, step, stages, &of_r);
    combine(pair->defect_T, step, stages, &of_T);
    combine(pair->rough, step, stages, &of_rough);
    combine(pair->rougher, step, stages, &of_rougher);
    return (struct defects){square_of(&of_r), square_of(&of_T), square_of(&of_rough),
                            square_of(&of_rougher)};
}

RMAP_COPIED struct defects defects_of(const struct rmap_curve_step *step)
{
    return step->pair == &rmap_curve_pair_8 ? defects_with(&rmap_curve_pair_8, 9, step)
                                            : defects_with(&rmap_curve_pair_6, 6, step);
}

/* The embedded defect is the error of the lower order, far more than that of the step. As in
 * Hairer, Norsett, Wanner 1993 (Solving Ordinary Differential Equations I, sec. II.10, eq. 10.17)
 * it is brought down by its ratio to a still lower order, where that ratio is small: in a smooth
 * field; at kinks all orders are alike and the defect stands. */
RMAP_WIDE
double rmap_curve_nystrom_error(const struct rmap_curve *curve, struct rmap_curve_step *step)
{
    const struct rmap_gradient *gradient = curve->gradient;
    const struct rmap_curve_pair *pair = step->pair;
    struct defects square = defects_of(step);
    double of_turn = sqrt(square.turn), of_rough = sqrt(square.rough);
    double of_rougher = sqrt(square.rougher);
    double h = step->h, place = h * sqrt(square.place);
    double fall = pair->smoothness * of_turn;
    if (of_rougher > 0.0) {
        fall = rmap_max(fall, pair->smoothness * of_rough * of_rough / of_rougher);
    }
    double share = fall < of_rough ? fall / of_rough : 1.0;
    double angle = of_turn / step->to.n * gradient->size;
    step->share = share;
    step->angle = angle;
    return rmap_max(share * h * place, share * h * angle) / gradient->options.tolerance;
}

RMAP_WIDE
double rmap_curve_nystrom_error_square(const struct rmap_curve *curve, struct rmap_curve_step *step)
{
    const struct rmap_gradient *gradient = curve->gradient;
    const struct rmap_curve_pair *pair = step->pair;
    struct defects of = defects_of(step);
    double tolerance = gradient->options.tolerance, n = step->to.n, h2 = step->h * step->h;
    double unit = 1.0 / (tolerance * tolerance), view = gradient->size / n;
    double smooth = pair->smoothness * pair->smoothness, share = smooth * of.turn / of.rough;
    if (of.rougher > 0.0) {
        share = rmap_max(share, smooth * of.rough / of.rougher);
    }
    share = share < 1.0 ? share : 1.0; /* uniform: 0 / 0 */
    double place = h2 * h2 * of.place, angle = h2 * of.turn * (view * view);
    step->share = share;
    step->angle = angle;
    return share * rmap_max(place, angle) * unit;
}

double rmap_curve_nystrom_between(const struct rmap_curve *curve,
                                  const struct rmap_curve_step *step)
{
    double tolerance = curve->gradient->options.tolerance, root = sqrt(step->share);
    if (!step->rough)
        return root * step->whole * step->angle / tolerance;
    double unit = 1.0 / (tolerance * tolerance);
    return sqrt(root * step->angle * unit);
}

RMAP_COPIED void dense_with(const struct rmap_curve_pair *pair, int stages,
                            struct rmap_curve_step *step)
{
    RMAP_UNROLL
    for (int k = 0; k < RMAP_CURVE_POWERS; k++) {
        rmap_wide bend;
        combine(pair->dense[k], step, stages, &bend);
        rmap_curve_set_bend(step, k, &bend);
    }
}

RMAP_WIDE
void rmap_curve_nystrom_finish(struct rmap_curve_step *step)
{
    if (step->pair == &rmap_curve_pair_8)
        dense_with(&rmap_curve_pair_8, 9, step);
    else
        dense_with(&rmap_curve_pair_6, 6, step);
    rmap_curve_measure(step);
}

RMAP_WIDE
bool rmap_curve_nystrom_finer(struct rmap_curve *curve, const struct rmap_curve_step *step,
                              double theta, struct rmap_vec3 *T)
{
    struct rmap_curve_state middle;
    double t = theta * step->h;
    struct rmap_vec3 sum = {0};
    rmap_curve_at(step, 0.5 * step->whole / step->h, &middle.r, &middle.T);
    if (!rmap_curve_evaluate(curve, &middle)) {
        return false;
    }
    for (int k = RMAP_CURVE_POWERS; k >= 0; k--) {
        const double *finer = step->pair->finer[k];
        rmap_wide bend;
        combine(finer, step, RMAP_CURVE_STAGES, &bend);
        sum = rmap_axpy(k + 2, rmap_axpy(finer[RMAP_CURVE_STAGES], middle.D, rmap_wide_vec3(&bend)),
                        rmap_scale(sum, t / step->whole));
    }
    *T = rmap_axpy(t, sum, step->from.T);
    return true;
}

/* The scheme of Sharma, Kumar, Ghatak 1982 (Appl. Opt. 21, 984, doi:10.1364/AO.21.000984): order 4
 * with three evaluations, of which the first is known from the step before. Between the ends: the
 * polynomial of degree 5 with their r, T and D. */

RMAP_WIDE
void rmap_curve_hermite_finish(struct rmap_curve_step *step)
{
    const struct rmap_curve_state *a = &step->from;
    const struct rmap_curve_state *b = &step->to;
    double h = step->h;
    double square = 1.0 / (h * h);
    /* What the parabola from the start misses at the end, over h^2: in place, h T, h^2 D. */
    struct rmap_vec3 chord = rmap_axpy(-h, a->T, rmap_sub(b->r, a->r));
    struct rmap_vec3 p0 = rmap_axpy(-0.5, a->D, rmap_scale(chord, square));
    struct rmap_vec3 p1 = rmap_sub(rmap_scale(rmap_sub(b->T, a->T), 1.0 / h), a->D);
    struct rmap_vec3 p2 = rmap_sub(b->D, a->D);
    const struct rmap_vec3 bend[] = {
        rmap_scale(a->D, 0.5),
        rmap_axpy(0.5, p2, rmap_axpy(-4.0, p1, rmap_scale(p0, 10.0))),
        rmap_axpy(-1.0, p2, rmap_axpy(7.0, p1, rmap_scale(p0, -15.0))),
        rmap_axpy(0.5, p2, rmap_axpy(-3.0, p1, rmap_scale(p0, 6.0))),
    };
    const int n = (int)(sizeof bend / sizeof bend[0]);
    for (int k = 0; k < RMAP_CURVE_POWERS; k++) {
        rmap_wide wide = {0};
        if (k < n)
            rmap_wide_set(&wide, bend[k]);
        rmap_curve_set_bend(step, k, &wide);
    }
    step->whole = h;
    step->pair = NULL;
    step->closed = false;
    step->n_stage = 0;
    rmap_curve_measure(step);
}

bool rmap_curve_sharma(struct rmap_curve *curve, struct rmap_curve_step *step, double h)
{
    const struct rmap_curve_state *from = &step->from;
    struct rmap_vec3 A = rmap_scale(from->D, h);
    struct rmap_curve_state at;
    at.r = rmap_axpy(h / 8, A, rmap_axpy(h / 2, from->T, from->r));
    if (!rmap_curve_evaluate(curve, &at)) {
        return false;
    }
    struct rmap_vec3 B = rmap_scale(at.D, h);
    at.r = rmap_axpy(h / 2, B, rmap_axpy(h, from->T, from->r));
    if (!rmap_curve_evaluate(curve, &at)) {
        return false;
    }
    struct rmap_vec3 C = rmap_scale(at.D, h);
    struct rmap_vec3 mean = rmap_scale(rmap_axpy(2.0, B, A), 1.0 / 6.0);
    struct rmap_vec3 turn = rmap_scale(rmap_add(rmap_axpy(4.0, B, A), C), 1.0 / 6.0);
    at.r = rmap_axpy(h, rmap_add(from->T, mean), from->r);
    at.T = rmap_add(from->T, turn);
    if (!rmap_curve_evaluate(curve, &at)) {
        return false;
    }
    step->to = at;
    step->h = h;
    rmap_curve_hermite_finish(step);
    return true;
}
