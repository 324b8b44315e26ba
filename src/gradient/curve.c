/* SPDX-License-Identifier: MIT
 *
 * Light through a gradient medium: the eikonal equation in optical-ray form (Sharma, Kumar, Ghatak
 * 1982, doi:10.1364/AO.21.000984), d2r/dt2 = D(r) = 1/2 grad n^2,   T = dr/dt = n dr/ds,   dt = ds
 * / n, step by step, with dense output.
 */
#include <float.h>
#include <string.h>

#include "gradient/curve.h"
#include "gradient/curve_step.h"

/* Step control: of the step that would just be allowed; least and greatest change at a time. */
static const double safety = 0.9;
static const double least_change = 0.1;
static const double greatest_change = 6.0;
/* A way of more steps is not divided evenly: its end is too far off to be planned for. */
static const double equal_parts = 4.0;

/* Square of the cosine of T to the gradient below which |T| is left alone, and the most that it is
 * taken to be wrong by, in errors of a step: a field whose gradient is not that of its index does
 * not keep it. */
static const double least_along = 0.1;
static const double most_errors = 100.0;

bool rmap_curve_evaluate(struct rmap_curve *curve, struct rmap_curve_state *state)
{
    struct rmap_vec3 slope;
    curve->n_evaluation++;
    if (!rmap_gradient_at(curve->gradient, curve->channel, state->r, &state->n, &slope)) {
        return false;
    }
    state->D = rmap_scale(slope, state->n);
    return true;
}

/* Shortest step worth taking, geometric: below it rounding rules. */
static double least_length(const struct rmap_curve *curve)
{
    return 1e-14 * curve->gradient->size + 8 * DBL_EPSILON * rmap_length(curve->state.r);
}

/* Logarithms of the errors of the pairs for a step of the length over which the field is like a
 * polynomial, measured on Luneburg's ray (sine and cosine of t): what the first steps are guessed
 * from. */
static const double log_unit_error_6 = -11.618; /* 9e-6 */
static const double log_unit_error_8 = -18.644; /* 8e-9 */
static const double first_share = 0.85;         /* of that: less is lost by a step too short */

static double first_step(const struct rmap_gradient *gradient, const struct rmap_curve_pair *pair,
                         double log_unit_error)
{
    double allowed = log(gradient->options.tolerance / gradient->size);
    return exp((allowed - log_unit_error) / pair->exponent);
}

void rmap_curve_prepare(struct rmap_gradient *gradient)
{
    gradient->options.first_6 = first_step(gradient, &rmap_curve_pair_6, log_unit_error_6);
    gradient->options.first_8 = first_step(gradient, &rmap_curve_pair_8, log_unit_error_8);
}

/* The steps in t, of either pair, that a field like a polynomial over `best_step` allows. */
static void guess_steps(struct rmap_curve *curve, struct rmap_vec3 direction)
{
    const struct rmap_gradient *gradient = curve->gradient;
    const struct rmap_field *field = gradient->field;
    double step_6 = gradient->options.first_6, step_8 = gradient->options.first_8;
    if (!(step_8 > 0.0)) {
        step_6 = first_step(gradient, &rmap_curve_pair_6, log_unit_error_6);
        step_8 = first_step(gradient, &rmap_curve_pair_8, log_unit_error_8);
    }
    double reach = gradient->size;
    if (field->ops->best_step) {
        struct rmap_vec3 p = rmap_affine_point(&gradient->to_local, curve->state.r);
        struct rmap_vec3 d = rmap_affine_vector(&gradient->to_local, direction);
        double stretch = rmap_length(d);
        reach = 2.0 * field->ops->best_step(field, p, rmap_scale(d, 1.0 / stretch)) / stretch;
    }
    if (!(reach > 0.0)) {
        reach = gradient->size;
    }
    curve->share_6 = step_6 / step_8;
    curve->next_h =
        rmap_min(first_share * safety * step_8 * reach, gradient->size) / curve->state.n;
}

bool rmap_curve_begin(struct rmap_curve *curve, const struct rmap_gradient *gradient, int channel,
                      struct rmap_vec3 origin, struct rmap_vec3 direction)
{
    curve->gradient = gradient;
    curve->channel = channel;
    curve->n_evaluation = curve->n_step = 0;
    curve->last_h = 0.0;
    curve->rough = curve->blind = false;
    curve->state.r = origin;
    if (!rmap_curve_evaluate(curve, &curve->state)) {
        return false;
    }
    curve->state.T = rmap_scale(direction, curve->state.n);
    rmap_curve_find_closed(curve);
    if (!curve->closed) {
        guess_steps(curve, direction);
    }
    return true;
}

/* Where even a step within the tolerance ends without a value: a parabola a little beyond, once, so
 * that a surface on the edge of a field is met. */
static bool step_blindly(struct rmap_curve *curve, struct rmap_curve_step *step)
{
    const struct rmap_curve_state *from = &step->from;
    if (curve->blind) {
        return false;
    }
    double h = 4.0 * curve->gradient->options.tolerance / from->n;
    struct rmap_curve_state *to = &step->to;
    to->r = rmap_axpy(h * h / 2, from->D, rmap_axpy(h, from->T, from->r));
    to->T = rmap_axpy(h, from->D, from->T);
    to->D = from->D;
    to->n = rmap_length(to->T);
    step->h = h;
    rmap_curve_hermite_finish(step);
    curve->blind = true;
    curve->next_h = h;
    return true;
}

/* x^-k to 1 %: the logarithm is read from the bits of x (Mitchell 1962,
 * doi:10.1109/TEC.1962.5219391), and a parabola stands for the power of 2. */
static inline double inverse_power_about(double x, double k)
{
    const double one = 0x1p52 * 1023.0;
    int64_t bits;
    memcpy(&bits, &x, sizeof bits);
    double power = (one - (double)bits) * 0x1p-52 * k;
    double whole = floor(power), part = power - whole;
    bits = ((int64_t)whole + 1023) << 52;
    memcpy(&x, &bits, sizeof bits);
    return x * (1.0 + part * (0.6565 + 0.3435 * part));
}

/* Of rough curves the error's square is given. */
static inline double change_after(const struct rmap_curve *curve,
                                  const struct rmap_curve_pair *pair, double error)
{
    double change = curve->rough ? inverse_power_about(rmap_max(error, 1e-20), 0.5 / pair->exponent)
                                 : exp(-log(rmap_max(error, 1e-10)) / pair->exponent);
    return rmap_min(rmap_max(safety * change, least_change), greatest_change);
}

/* The step that an error suggests next, of the pair of order 8. */
static inline double suggest(const struct rmap_curve *curve, const struct rmap_curve_pair *pair,
                             double h, double error, double growth)
{
    double share = pair == &rmap_curve_pair_6 ? curve->share_6 : 1.0;
    double change = change_after(curve, pair, error);
    double next = h / share * rmap_min(change, growth);
    return share < 1.0 ? next * (safety * safety) : next; /* across the pairs it is less sure */
}

/* From the last step; one that was cut very short says little about the next. */
static inline void learn(struct rmap_curve *curve)
{
    double h = curve->last_h;
    if (!(h > 0.0))
        return;
    const struct rmap_curve_pair *pair = curve->last_pair;
    double share = pair == &rmap_curve_pair_6 ? curve->share_6 : 1.0;
    double next = suggest(curve, pair, h, curve->last_error, curve->last_growth);
    curve->next_h = h < 0.4 * share * curve->next_h ? rmap_max(next, curve->next_h) : next;
    curve->last_h = 0.0;
}

/* Steps to the end of a way, in t: the pair of order 6 where one of its steps is enough, or where
 * neither the field nor the way is known yet; else full steps of order 8 where the rest is then one
 * of order 6; else equal ones. */
static inline const struct rmap_curve_pair *plan_step(const struct rmap_curve *curve, double way,
                                                      double *h)
{
    double full = curve->next_h, small = curve->share_6 * full;
    double parts = ceil(way / full);
    bool last = way <= small, blank = curve->n_step == 0 && !(way < HUGE_VAL);
    *h = last || blank ? small : full;
    if (!last && parts <= equal_parts && way - (parts - 1.0) * full > safety * small)
        *h = way / parts;
    *h = rmap_min(*h, way);
    return last || blank ? &rmap_curve_pair_6 : &rmap_curve_pair_8;
}

/* |T| = n again, by a push along the gradient: where the index falls later on, what |T|^2 - n^2 is
 * wrong by bends light by the square of that fall more. T across the gradient, which a rod and a
 * ball keep, stays as it is. (Projection onto an invariant: Hairer, Lubich & Wanner 2006, Geometric
 * Numerical Integration, IV.4.) */
static inline void keep_invariant(const struct rmap_gradient *gradient,
                                  struct rmap_curve_state *state)
{
    double square = rmap_dot(state->T, state->T), along = rmap_dot(state->T, state->D);
    double wrong = state->n * state->n - square;
    if (fabs(wrong) * gradient->size < most_errors * gradient->options.tolerance * square &&
        along * along > least_along * square * rmap_dot(state->D, state->D))
        state->T = rmap_axpy(wrong / (2 * along), state->D, state->T);
}

/* Error-controlled; `way`, to where the caller would like to get, and `longest` are in t. */
RMAP_COPIED bool advance_adaptive(struct rmap_curve *curve, struct rmap_curve_step *step,
                                  double way, double longest)
{
    double growth = greatest_change;
    learn(curve);
    for (;; growth = 1.0) {
        double h;
        const struct rmap_curve_pair *pair = plan_step(curve, way, &h);
        double share = pair == &rmap_curve_pair_6 ? curve->share_6 : 1.0;
        h = rmap_min(h, longest);
        if (!rmap_curve_nystrom(curve, pair, step, h)) {
            if (h <= curve->gradient->options.tolerance / curve->state.n) {
                return step_blindly(curve, step);
            }
            way = longest = 0.25 * h;
            continue;
        }
        double error = curve->rough ? rmap_curve_nystrom_error_square(curve, step)
                                    : rmap_curve_nystrom_error(curve, step);
        if (error <= 1.0) {
            keep_invariant(curve->gradient, &step->to);
            curve->last_h = h;
            curve->last_pair = pair;
            curve->last_error = error;
            curve->last_growth = growth;
            curve->blind = false;
            rmap_curve_nystrom_finish(step);
            return true;
        }
        double least = least_length(curve) / curve->state.n;
        if (h < 2.0 * least) { /* a singular place */
            return false;
        }
        curve->next_h = rmap_max(least / share, suggest(curve, pair, h, error, 1.0));
    }
}

/* Steps in closed form. What bounds their dense output takes light to go at most as fast as the
 * body's size lets it, and to turn by not much more than a right angle. */
static bool advance_closed(struct rmap_curve *curve, struct rmap_curve_step *step, double longest)
{
    const struct rmap_gradient *gradient = curve->gradient;
    double n = curve->state.n;
    double turn = 2.0 * n / rmap_length(curve->state.D); /* straight: infinite */
    double h = rmap_min(rmap_min(curve->closed_h, longest), turn);
    while (!rmap_curve_closed(curve, step, h) || h * step->to.n > 1.25 * gradient->size) {
        if (h <= gradient->options.tolerance / n) {
            return step_blindly(curve, step);
        }
        h *= 0.5;
    }
    curve->blind = false;
    return true;
}

/* Sharma's scheme in steps of a given length; shorter only where the field ends. */
static bool advance_sharma(struct rmap_curve *curve, struct rmap_curve_step *step, double h)
{
    double blind = curve->gradient->options.tolerance / curve->state.n;
    while (!rmap_curve_sharma(curve, step, h)) {
        if (h <= blind) {
            return step_blindly(curve, step);
        }
        h *= 0.25;
    }
    curve->blind = false;
    return true;
}

/* The longest steps where light runs across the gradient. */
static double seed_length(const struct rmap_curve_options *options,
                          const struct rmap_curve_state *state)
{
    double along = fabs(rmap_dot(state->T, state->D)) / (state->n * state->n);
    double share = rmap_min(rmap_max(1.0 - along / options->amplitude, 0.0), 1.0);
    return options->step_min + share * (options->step_max - options->step_min);
}

RMAP_WIDE
bool rmap_curve_advance(struct rmap_curve *curve, double length_max, struct rmap_curve_step *step)
{
    const struct rmap_curve_options *options = &curve->gradient->options;
    double n = curve->state.n;
    double longest = rmap_min(length_max, curve->gradient->size) / n;
    bool done = false; /* by no scheme */
    step->from = curve->state;
    step->allowed = options->tolerance;
    step->rough = curve->rough;
    step->closed = false;
    switch (options->scheme) {
    case RMAP_SCHEME_ADAPTIVE:
    case RMAP_SCHEME_INTEGRATED:
        done = curve->closed ? advance_closed(curve, step, longest)
                             : advance_adaptive(curve, step, length_max / n, longest);
        break;
    case RMAP_SCHEME_SHARMA:
        done =
            advance_sharma(curve, step, rmap_min(seed_length(options, &curve->state) / n, longest));
        break;
    case RMAP_SCHEME_SHARMA_FIXED:
        done = advance_sharma(curve, step, rmap_min(options->step / n, longest));
        break;
    }
    if (done) {
        curve->state = step->to;
        curve->n_step++;
    }
    return done;
}

/* Between the stages. */
#define MARGIN 1.1

/* Square of the part of D across a direction; from its whole square, so good to 1e-8 D alone. */
static double across(struct rmap_vec3 D, struct rmap_vec3 along, double inverse_square)
{
    double part = rmap_dot(D, along);
    return rmap_dot(D, D) - part * part * inverse_square;
}

/* The same of four D. */
static inline void across_four(const double (*D)[4], struct rmap_vec3 along, double inverse_square,
                               double of[4])
{
    rmap_wide x = {D[0][0], D[1][0], D[2][0], D[3][0]};
    rmap_wide y = {D[0][1], D[1][1], D[2][1], D[3][1]};
    rmap_wide z = {D[0][2], D[1][2], D[2][2], D[3][2]};
    rmap_wide part = x * along.x + y * along.y + z * along.z;
    rmap_wide square = x * x + y * y + z * z - part * part * inverse_square;
    rmap_wide_store(&square, of);
}

RMAP_WIDE
double rmap_curve_bend(const struct rmap_curve_step *step)
{
    const struct rmap_curve_state *from = &step->from, *to = &step->to;
    double first = across(from->D, from->T, 1.0 / rmap_dot(from->T, from->T));
    double last = across(to->D, to->T, 1.0 / rmap_dot(to->T, to->T));
    double most = rmap_max(0.0, rmap_max(first, last));
    struct rmap_vec3 way = rmap_sub(to->r, from->r);
    double inverse_square = 1.0 / rmap_dot(way, way);
    /* a way of no length: NaN, passed over */
    if (step->pair) {
        double inner[4];
        across_four(&step->D[step->pair->inner], way, inverse_square, inner);
        for (int i = 0; i < 4; i++)
            most = rmap_max(inner[i], most);
    }
    for (int i = 1; !step->pair && i < step->n_stage; i++) {
        const double *D = step->D[i];
        most = rmap_max(across(rmap_vec3(D[0], D[1], D[2]), way, inverse_square), most);
    }
    return MARGIN * sqrt(most);
}

/* Dense output of the steps of any scheme. */

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

double rmap_curve_group(const struct rmap_gradient *gradient, int channel,
                        const struct rmap_curve_step *step, double theta)
{
    double sum = 0.0, optical, length;
    if (!gradient->beside) {
        rmap_curve_lengths(step, theta, &optical, &length);
        return optical;
    }
    const double half = 0.5 * theta;
    for (int i = 0; i < 8; i++) {
        struct rmap_vec3 r, T;
        rmap_curve_at(step, half * (1.0 + gauss_node[i]), &r, &T);
        const double n = rmap_length(T);
        sum += gauss_weight[i] * n * rmap_gradient_group(gradient, channel, r, n);
    }
    return half * step->h * sum;
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
