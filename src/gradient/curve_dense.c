/* SPDX-License-Identifier: MIT
 *
 * Dense output of the steps of any scheme.
 */
#include <float.h>

#include "gradient/curve_internal.h"

RMAP_WIDE
void rmap_curve_at(const struct rmap_curve_step *step, double theta, struct rmap_vec3 *r,
                   struct rmap_vec3 *T)
{
    double t = theta * step->h;
    rmap_curve_dense(step, t, t / step->whole, r, T);
}

/* from + t of for four t at once */
static inline void abreast(const rmap_wide *t, double from, rmap_wide *of)
{
    *of = from + *of * *t;
}

/* |T|^2 at four places, in t and as shares of the whole step, at once. */
static inline void squares(const struct rmap_curve_step *step, const rmap_wide *t,
                           const rmap_wide *share, rmap_wide *square)
{
    rmap_wide x = {0}, y = {0}, z = {0};
    for (int k = RMAP_CURVE_POWERS - 1; k >= 0; k--) {
        abreast(share, step->turn[k][0], &x);
        abreast(share, step->turn[k][1], &y);
        abreast(share, step->turn[k][2], &z);
    }
    abreast(t, step->from.T.x, &x);
    abreast(t, step->from.T.y, &y);
    abreast(t, step->from.T.z, &z);
    *square = x * x + y * y + z * z;
}

/* How much Gauss's formula of eight points misses of the integral of n over [-1, 1]: the sixteenth
 * of n's coefficients in Legendre's polynomials. The sixth and seventh, and how fast they fell
 * since the fourth and fifth, tell it, of which not all is believed: the third power, not 9/2. */
static double missed(const double n[8], double sum)
{
    /* weight (k + 1/2) P_k at the latter four nodes, k = 4 ... 7 */
    static const double order[4][4] = {
        {0.41417609673681377, -0.4615853225965301, -0.24289619147803762, 0.2903054173377549},
        {0.5816088634493214, 0.05356581100520451, -0.49329537666193657, 0.26882935877865455},
        {-0.26738967142620357, 0.6166048635025356, -0.5591073831433642, 0.2098921910670325},
        {-0.7849065579218125, 0.6317745531190043, -0.3778969370845917, 0.11769245644771324}};
    double of[4] = {0.0};
    for (int i = 0; i < 4; i++) {
        double even = n[4 + i] + n[3 - i], odd = n[4 + i] - n[3 - i];
        of[0] += order[0][i] * even;
        of[1] += order[1][i] * odd;
        of[2] += order[2][i] * even;
        of[3] += order[3][i] * odd;
    }
    double last = fabs(of[2]) + fabs(of[3]);
    double fall = rmap_min(1.0, last / (fabs(of[0]) + fabs(of[1]) + DBL_MIN));
    return last * rmap_max(fall * fall * fall, last / sum);
}

static const double gauss_node[8] = {-0.9602898564975362,  -0.7966664774136267, -0.525532409916329,
                                     -0.18343464249564978, 0.18343464249564978, 0.525532409916329,
                                     0.7966664774136267,   0.9602898564975362};

static const double gauss_weight[8] = {
    0.10122853629037669, 0.22238103445337434, 0.31370664587788705, 0.36268378337836177,
    0.36268378337836177, 0.31370664587788705, 0.22238103445337434, 0.10122853629037669};

/* n^2 at the nodes of a part of the step: from `from` half-widths of it on, in t */
static inline void squares_of_part(const struct rmap_curve_step *step, double from, double half,
                                   double square[8])
{
    for (int i = 0; i < 8; i += 4) {
        rmap_wide t, share, four;
        rmap_wide_load(&t, &gauss_node[i]);
        t = (t + from) * half;
        share = t / step->whole;
        squares(step, &t, &share, &four);
        rmap_wide_store(&four, &square[i]);
    }
}

/* Gauss's formula with n = |T| of the dense output: n is a rougher function of t than r and T are,
 * and here it costs no evaluation. Steps in closed form may be long for it: in parts. */
RMAP_WIDE
void rmap_curve_lengths(const struct rmap_curve_step *step, double theta, double *optical,
                        double *length)
{
    const int most = 32;
    double error;
    int parts = 1;
    do {
        double half = 0.5 * theta * step->h / parts;
        *optical = *length = error = 0.0;
        for (int part = 0; part < parts; part++) {
            double square[8], n[8], sum_square = 0.0, sum = 0.0;
            squares_of_part(step, 2 * part + 1, half, square);
            for (int i = 0; i < 8; i++) {
                n[i] = sqrt(square[i]);
                sum_square += gauss_weight[i] * square[i];
                sum += gauss_weight[i] * n[i];
            }
            *optical += half * sum_square;
            *length += half * sum;
            if (step->closed)
                error += half * missed(n, sum);
        }
        parts *= 2;
    } while (error > step->allowed && parts <= most);
}

void rmap_curve_measure(struct rmap_curve_step *step)
{
    const struct rmap_curve_state *from = &step->from, *to = &step->to;
    if (step->rough) {
        step->optical = 0.5 * step->h * (from->n * from->n + to->n * to->n);
        step->length = 0.5 * step->h * (from->n + to->n);
        return;
    }
    rmap_curve_lengths(step, 1.0, &step->optical, &step->length);
}

/* The dense output's end made a step of its own, T improved where that has a need. */
static void cut_dense(struct rmap_curve *curve, struct rmap_curve_step *step, double theta)
{
    struct rmap_curve_state *to = &step->to;
    double optical = 0.0, length = 0.0;
    rmap_curve_at(step, theta, &to->r, &to->T);
    if (!step->rough)
        rmap_curve_lengths(step, theta, &optical, &length);
    if (step->pair && step->pair->has_finer && rmap_curve_nystrom_between(curve, step) > 1.0) {
        (void)rmap_curve_nystrom_finer(curve, step, theta, &to->T);
    }
    step->h = theta * step->h;
    if (step->rough) { /* its direction is all that counts */
        to->n = rmap_length(to->T);
        rmap_curve_measure(step);
        return;
    }
    if (!rmap_curve_evaluate(curve, to)) { /* the edge of the field, within rounding */
        to->n = rmap_length(to->T);
    }
    to->T = rmap_scale(to->T, to->n / rmap_length(to->T));
    step->optical = optical;
    step->length = length;
}

/* The step taken anew to there, where dense output would be too coarse. */
static bool cut_anew(struct rmap_curve *curve, struct rmap_curve_step *step, double theta)
{
    if (step->closed) {
        return rmap_curve_closed(curve, step, theta * step->h);
    }
    if (!step->pair) {
        return rmap_curve_sharma(curve, step, theta * step->h);
    }
    if (step->pair->has_finer || rmap_curve_nystrom_between(curve, step) <= 1.0) {
        return false;
    }
    struct rmap_curve_step shorter = *step;
    if (!rmap_curve_nystrom(curve, step->pair, &shorter, theta * step->h)) {
        return false;
    }
    (void)rmap_curve_nystrom_error(curve, &shorter);
    rmap_curve_nystrom_finish(&shorter);
    *step = shorter;
    return true;
}

bool rmap_curve_cut(struct rmap_curve *curve, struct rmap_curve_step *step, double theta)
{
    if (theta != 1.0 && !cut_anew(curve, step, theta)) {
        cut_dense(curve, step, theta);
    }
    curve->state = step->to;
    return true;
}

static double distance_to_chord(struct rmap_vec3 p, struct rmap_vec3 a, struct rmap_vec3 b)
{
    struct rmap_vec3 ab = rmap_sub(b, a);
    struct rmap_vec3 ap = rmap_sub(p, a);
    double square = rmap_dot(ab, ab);
    double along = square > 0.0 ? fmin(fmax(rmap_dot(ap, ab) / square, 0.0), 1.0) : 0.0;
    return rmap_length(rmap_axpy(-along, ab, ap));
}

double rmap_curve_sag(const struct rmap_curve_step *step, double theta0, double theta1)
{
    enum { PARTS = 4 };
    struct rmap_vec3 p[PARTS + 1];
    struct rmap_vec3 T;
    double sag = 0.0;
    for (int i = 0; i <= PARTS; i++) {
        rmap_curve_at(step, theta0 + (theta1 - theta0) * i / PARTS, &p[i], &T);
    }
    for (int i = 1; i < PARTS; i++) {
        sag = fmax(sag, distance_to_chord(p[i], p[0], p[PARTS]));
    }
    return 1.05 * sag; /* between the samples */
}
