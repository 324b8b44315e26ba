/* SPDX-License-Identifier: MIT
 *
 * Polynomials in x, y, z, of n or of n^2.
 */
#include <string.h>

#include "base/alloc.h"
#include "gradient/field_internal.h"
#include "gradient/field_made.h"
#include "gradient/field_polynomial.h"

#define POWER_MAX 64

struct polynomial {
    struct rmap_field base;
    enum rmap_series_of q;
    int n_term, top[3];   /* greatest powers of x, y, z */
    int (*power)[3];      /* [n_term], owned */
    double coefficient[]; /* [n_channel][n_term] */
};

static const struct polynomial *polynomial_of(const struct rmap_field *field)
{
    return (const struct polynomial *)(const void *)field;
}

/* x^i, its first and its second derivative for i in [0, top]. */
static void powers(double x, int top, double of[POWER_MAX + 1][3])
{
    double power[POWER_MAX + 1];
    power[0] = 1.0;
    for (int i = 1; i <= top; i++)
        power[i] = power[i - 1] * x;
    for (int i = 0; i <= top; i++) {
        of[i][0] = power[i];
        of[i][1] = i > 0 ? i * power[i - 1] : 0.0;
        of[i][2] = i > 1 ? i * (i - 1) * power[i - 2] : 0.0;
    }
}

/* q, its gradient and its Laplacian. */
static double sum_terms(const struct polynomial *self, int channel, struct rmap_vec3 p,
                        struct rmap_vec3 *gradient, double *laplacian)
{
    double x[POWER_MAX + 1][3], y[POWER_MAX + 1][3], z[POWER_MAX + 1][3], q = 0.0, bend = 0.0;
    struct rmap_vec3 slope = {0, 0, 0};
    const double *coefficient = self->coefficient + (size_t)channel * (size_t)self->n_term;
    powers(p.x, self->top[0], x);
    powers(p.y, self->top[1], y);
    powers(p.z, self->top[2], z);
    for (int t = 0; t < self->n_term; t++) {
        const double *i = x[self->power[t][0]], *j = y[self->power[t][1]],
                     *k = z[self->power[t][2]];
        double c = coefficient[t];
        q += c * i[0] * j[0] * k[0];
        slope.x += c * i[1] * j[0] * k[0];
        slope.y += c * i[0] * j[1] * k[0];
        slope.z += c * i[0] * j[0] * k[1];
        bend += c * (i[2] * j[0] * k[0] + i[0] * j[2] * k[0] + i[0] * j[0] * k[2]);
    }
    *gradient = slope;
    *laplacian = bend;
    return q;
}

static bool polynomial_at(const struct rmap_field *field, int channel, struct rmap_vec3 p,
                          double *n, struct rmap_vec3 *gradient)
{
    const struct polynomial *self = polynomial_of(field);
    double laplacian;
    *n = sum_terms(self, channel, p, gradient, &laplacian);
    if (self->q == RMAP_SERIES_OF_N)
        return true;
    if (!(*n > 0.0))
        return false;
    *n = sqrt(*n);
    *gradient = rmap_scale(*gradient, 0.5 / *n);
    return true;
}

static bool polynomial_laplacian(const struct rmap_field *field, int channel, struct rmap_vec3 p,
                                 double *laplacian)
{
    const struct polynomial *self = polynomial_of(field);
    struct rmap_vec3 gradient;
    double q = sum_terms(self, channel, p, &gradient, laplacian);
    if (self->q == RMAP_SERIES_OF_N_SQUARED)
        *laplacian = (0.5 * *laplacian - 0.25 * rmap_dot(gradient, gradient) / q) / sqrt(q);
    return isfinite(*laplacian);
}

static bool polynomial_quadratic(const struct rmap_field *field, int channel, double bend[3][3])
{
    const struct polynomial *self = polynomial_of(field);
    const double *coefficient = self->coefficient + (size_t)channel * (size_t)self->n_term;
    const int degree = self->q == RMAP_SERIES_OF_N ? 0 : 2;
    memset(bend, 0, 9 * sizeof bend[0][0]);
    for (int t = 0; t < self->n_term; t++) {
        const int *power = self->power[t];
        if (coefficient[t] != 0.0 && power[0] + power[1] + power[2] > degree)
            return false;
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++)
                if (i == j ? power[i] == 2 : power[i] == 1 && power[j] == 1)
                    bend[i][j] += i == j ? coefficient[t] : 0.5 * coefficient[t];
    }
    return true;
}

static void polynomial_destroy(struct rmap_field *field)
{
    rmap_free(((struct polynomial *)(void *)field)->power);
    rmap_free(field);
}

static const struct rmap_field_ops polynomial_ops = {.model = "polynomial",
                                                     .at = polynomial_at,
                                                     .laplacian = polynomial_laplacian,
                                                     .best_step = rmap_field_best_step,
                                                     .quadratic = polynomial_quadratic,
                                                     .destroy = polynomial_destroy};

static enum rmap_status check(int n_channel, int n_term, const int (*power)[3],
                              const double *coefficient, struct rmap_error *err)
{
    const struct rmap_parameter finite = {"a coefficient", RMAP_NEED_FINITE};
    if (n_term < 1)
        return rmap_error_set(err, RMAP_INPUT, "polynomial: give at least one term");
    for (int t = 0; t < n_term; t++)
        for (int axis = 0; axis < 3; axis++)
            if (power[t][axis] < 0 || power[t][axis] > POWER_MAX)
                return rmap_error_set(err, RMAP_INPUT,
                                      "polynomial: term %d has the power %d; from 0 to %d", t + 1,
                                      power[t][axis], POWER_MAX);
    for (size_t i = 0; i < (size_t)n_channel * (size_t)n_term; i++) {
        enum rmap_status st = rmap_parameter_check("polynomial", &finite, coefficient[i], err);
        if (st != RMAP_OK)
            return st;
    }
    return RMAP_OK;
}

enum rmap_status rmap_field_polynomial(struct rmap_field **field_ret, enum rmap_series_of q,
                                       int n_channel, int n_term, const int (*power)[3],
                                       const double *coefficient, struct rmap_error *err)
{
    enum rmap_status st = check(n_channel, n_term, power, coefficient, err);
    if (st != RMAP_OK)
        return st;
    size_t n = (size_t)n_channel * (size_t)n_term;
    struct polynomial *self = (struct polynomial *)(void *)rmap_field_new(
        sizeof(struct polynomial) + n * sizeof(double), &polynomial_ops, n_channel, err);
    if (!self)
        return RMAP_SYSTEM;
    self->power = rmap_alloc((size_t)n_term, sizeof *self->power);
    if (!self->power) {
        rmap_field_destroy(&self->base);
        return rmap_error_set(err, RMAP_SYSTEM, "polynomial: no memory");
    }
    self->q = q;
    self->n_term = n_term;
    self->base.may_be_missing = true;
    memcpy(self->power, power, (size_t)n_term * sizeof *power);
    memcpy(self->coefficient, coefficient, n * sizeof(double));
    for (int t = 0; t < n_term; t++)
        for (int axis = 0; axis < 3; axis++)
            if (power[t][axis] > self->top[axis])
                self->top[axis] = power[t][axis];
    *field_ret = &self->base;
    return RMAP_OK;
}

/* Power series in z, rho^2 or r^2, of n or of n^2, and the models that are one: Luneburg's and
 * Gutman's lenses, the parabolic and the selfoc rod. */

/* Horner's rule for a polynomial and its first two derivatives. */
bool rmap_jet_series(const double *parameter, int n_parameter, double s, double jet[3])
{
    double q = parameter[n_parameter - 1], first = 0.0, half_second = 0.0;
    for (int i = n_parameter - 2; i >= 0; i--) {
        half_second = half_second * s + first;
        first = first * s + q;
        q = q * s + parameter[i];
    }
    jet[0] = q;
    jet[1] = first;
    jet[2] = 2.0 * half_second;
    return true;
}

#define SERIES_OF(s_of, q_of)                                                                      \
    {                                                                                              \
        .model = "series", .s = (s_of), .q = (q_of), .jet = rmap_jet_series,                       \
        .may_be_missing = true                                                                     \
    }

static const struct rmap_jet_model series[3][2] = {
    [RMAP_SERIES_Z] = {SERIES_OF(RMAP_SERIES_Z, RMAP_SERIES_OF_N),
                       SERIES_OF(RMAP_SERIES_Z, RMAP_SERIES_OF_N_SQUARED)},
    [RMAP_SERIES_RHO2] = {SERIES_OF(RMAP_SERIES_RHO2, RMAP_SERIES_OF_N),
                          SERIES_OF(RMAP_SERIES_RHO2, RMAP_SERIES_OF_N_SQUARED)},
    [RMAP_SERIES_R2] = {SERIES_OF(RMAP_SERIES_R2, RMAP_SERIES_OF_N),
                        SERIES_OF(RMAP_SERIES_R2, RMAP_SERIES_OF_N_SQUARED)}};

enum rmap_status rmap_field_series(struct rmap_field **field_ret, enum rmap_series_variable s,
                                   enum rmap_series_of q, int n_channel, int n_coefficient,
                                   const double *coefficient, struct rmap_error *err)
{
    if (n_coefficient < 1)
        return rmap_error_set(err, RMAP_INPUT, "series: give at least one coefficient");
    const struct rmap_parameter finite = {"a coefficient", RMAP_NEED_FINITE};
    for (size_t i = 0; i < (size_t)n_channel * (size_t)n_coefficient; i++) {
        enum rmap_status st = rmap_parameter_check("series", &finite, coefficient[i], err);
        if (st != RMAP_OK)
            return st;
    }
    return rmap_field_of_jet(field_ret, &series[s][q], n_channel, n_coefficient, coefficient, err);
}

/* n_edge^2 (1 + (radius^2 - r^2) / focus^2) (Gutman 1954, J. Appl. Phys. 25, 855) */
static void prepare_gutman(const double *given, double *kept)
{
    double edge2 = given[0] * given[0], ratio = given[1] / given[2];
    kept[0] = edge2 * (1.0 + ratio * ratio);
    kept[1] = -edge2 / (given[2] * given[2]);
}

/* Luneburg 1944, Mathematical Theory of Optics, sec. 28: Gutman's with the focus on the rim */
static void prepare_luneburg(const double *given, double *kept)
{
    const double gutman[3] = {given[0], given[1], given[1]};
    prepare_gutman(gutman, kept);
}

static void prepare_parabolic(const double *given, double *kept)
{
    kept[0] = given[0] * given[0];
    kept[1] = -kept[0] * given[1] * given[1];
}

static void prepare_selfoc(const double *given, double *kept)
{
    kept[0] = given[0];
    kept[1] = -0.5 * given[0] * given[1];
}

static const struct rmap_jet_model gutman = {.model = "gutman",
                                             .s = RMAP_SERIES_R2,
                                             .q = RMAP_SERIES_OF_N_SQUARED,
                                             .jet = rmap_jet_series,
                                             .may_be_missing = true,
                                             .n_parameter = 3,
                                             .parameter = {{"n_edge", RMAP_NEED_POSITIVE},
                                                           {"radius", RMAP_NEED_POSITIVE},
                                                           {"focus", RMAP_NEED_POSITIVE}},
                                             .prepare = prepare_gutman,
                                             .n_kept = 2};

static const struct rmap_jet_model luneburg = {
    .model = "luneburg",
    .s = RMAP_SERIES_R2,
    .q = RMAP_SERIES_OF_N_SQUARED,
    .jet = rmap_jet_series,
    .may_be_missing = true,
    .n_parameter = 2,
    .parameter = {{"n_edge", RMAP_NEED_POSITIVE}, {"radius", RMAP_NEED_POSITIVE}},
    .prepare = prepare_luneburg,
    .n_kept = 2};

static const struct rmap_jet_model parabolic = {
    .model = "parabolic",
    .s = RMAP_SERIES_RHO2,
    .q = RMAP_SERIES_OF_N_SQUARED,
    .jet = rmap_jet_series,
    .may_be_missing = true,
    .n_parameter = 2,
    .parameter = {{"n0", RMAP_NEED_POSITIVE}, {"alpha", RMAP_NEED_FINITE}},
    .prepare = prepare_parabolic,
    .n_kept = 2};

static const struct rmap_jet_model selfoc = {
    .model = "selfoc",
    .s = RMAP_SERIES_RHO2,
    .q = RMAP_SERIES_OF_N,
    .jet = rmap_jet_series,
    .may_be_missing = true,
    .n_parameter = 2,
    .parameter = {{"n0", RMAP_NEED_POSITIVE}, {"A", RMAP_NEED_FINITE}},
    .prepare = prepare_selfoc,
    .n_kept = 2};

enum rmap_status rmap_field_luneburg(struct rmap_field **field_ret, int n_channel,
                                     const struct rmap_luneburg *parameter, struct rmap_error *err)
{
    return rmap_field_of_model(field_ret, &luneburg, n_channel, parameter, err);
}

enum rmap_status rmap_field_gutman(struct rmap_field **field_ret, int n_channel,
                                   const struct rmap_gutman *parameter, struct rmap_error *err)
{
    return rmap_field_of_model(field_ret, &gutman, n_channel, parameter, err);
}

enum rmap_status rmap_field_parabolic(struct rmap_field **field_ret, int n_channel,
                                      const struct rmap_parabolic *parameter,
                                      struct rmap_error *err)
{
    return rmap_field_of_model(field_ret, &parabolic, n_channel, parameter, err);
}

enum rmap_status rmap_field_selfoc(struct rmap_field **field_ret, int n_channel,
                                   const struct rmap_selfoc *parameter, struct rmap_error *err)
{
    return rmap_field_of_model(field_ret, &selfoc, n_channel, parameter, err);
}

/* The gradient surfaces of Zemax (OpticStudio User Guide, "Gradient 1" to "Gradient 12"), their
 * media alone: sag and aperture are the surfaces' business. r^2 = x^2 + y^2.
 *
 *  1  n   = n0 + nr2 r^2 + nr1 r
 *  2  n^2 = n0 + nr2 r^2 + nr4 r^4 + ... + nr12 r^12
 *  3  n   = n0 + nr2 r^2 + nr4 r^4 + nr6 r^6 + nz1 z + nz2 z^2 + nz3 z^3
 *  4  n   = n0 + nx1 x + nx2 x^2 + ny1 y + ny2 y^2 + nz1 z + nz2 z^2
 *  5  n   = n0 + nr2 r^2 + nr4 r^4 + nz1 z + ... + nz4 z^4
 *  6  n   = n_0 + n_1 r^2 + ... + n_4 r^8, n_i = Ai + Bi l^2 + Ci/l^2 + Di/l^4, l in nm
 *  7  n   = n0 + alpha (R - q) + beta (R - q)^2, q = R/|R| sqrt(x^2 + y^2 + (R - z)^2)
 *  9  n   = n0 (1 - A r^2 / 2), n0 = B + C/l^2, A = (K0 + K1/l^2 + K2/l^4)^2, l in um
 * 10  n   = n0 + ny1 |y| + ... + ny6 |y|^6
 * 12  n   = n0 + sum over i of cxi x^i + cyi y^i + czi z^i, i to 20 */

#define TRIPLE(i) "cx" #i, "cy" #i, "cz" #i
#define FOUR(i)   "A" #i, "B" #i, "C" #i, "D" #i

static const char *const name_of[][RMAP_ZEMAX_PARAMETER_MAX] = {
    [1] = {"n0", "nr2", "nr1"},
    [2] = {"n0", "nr2", "nr4", "nr6", "nr8", "nr10", "nr12"},
    [3] = {"n0", "nr2", "nr4", "nr6", "nz1", "nz2", "nz3"},
    [4] = {"n0", "nx1", "nx2", "ny1", "ny2", "nz1", "nz2"},
    [5] = {"n0", "nr2", "nr4", "nz1", "nz2", "nz3", "nz4"},
    [6] = {FOUR(0), FOUR(1), FOUR(2), FOUR(3), FOUR(4)},
    [7] = {"n0", "R", "alpha", "beta"},
    [9] = {"B", "C", "K0", "K1", "K2"},
    [10] = {"n0", "ny1", "ny2", "ny3", "ny4", "ny5", "ny6"},
    [12] = {"n0",       TRIPLE(1),  TRIPLE(2),  TRIPLE(3),  TRIPLE(4),  TRIPLE(5),  TRIPLE(6),
            TRIPLE(7),  TRIPLE(8),  TRIPLE(9),  TRIPLE(10), TRIPLE(11), TRIPLE(12), TRIPLE(13),
            TRIPLE(14), TRIPLE(15), TRIPLE(16), TRIPLE(17), TRIPLE(18), TRIPLE(19), TRIPLE(20)}};

#define N_TYPE ((int)(sizeof name_of / sizeof name_of[0]))

const char *rmap_zemax_parameter(int type, int i)
{
    if (type < 0 || type >= N_TYPE || i < 0 || i >= RMAP_ZEMAX_PARAMETER_MAX)
        return NULL;
    return name_of[type][i];
}

/* ---- 1: with a cone about the axis, where nr1 has no slope of its own ---- */

static bool jet_1(const double *parameter, int n_parameter, double s, double jet[3])
{
    (void)n_parameter;
    double r = sqrt(s), cone = r > 0.0 ? 0.5 * parameter[2] / r : 0.0;
    jet[0] = parameter[0] + parameter[1] * s + parameter[2] * r;
    jet[1] = parameter[1] + cone;
    jet[2] = s > 0.0 ? -0.5 * cone / s : 0.0;
    return true;
}

static const struct rmap_jet_model gradient_1 = {.model = "zemax 1",
                                                 .s = RMAP_SERIES_RHO2,
                                                 .q = RMAP_SERIES_OF_N,
                                                 .jet = jet_1,
                                                 .may_be_missing = true};

/* ---- 7: shells about (0, 0, R) ---- */

static bool jet_7(const double *parameter, int n_parameter, double s, double jet[3])
{
    (void)n_parameter;
    if (!(s > 0.0))
        return false;
    double sign = copysign(1.0, parameter[1]), q = sqrt(s), u = parameter[1] - sign * q;
    const double f[3] = {parameter[0] + u * (parameter[2] + u * parameter[3]),
                         -sign * (parameter[2] + 2.0 * u * parameter[3]), 2.0 * parameter[3]};
    rmap_jet_of_radius(q, f, jet);
    return true;
}

static const struct rmap_jet_model gradient_7 = {.model = "zemax 7",
                                                 .s = RMAP_SERIES_R2,
                                                 .q = RMAP_SERIES_OF_N,
                                                 .jet = jet_7,
                                                 .may_be_missing = true};

static enum rmap_status make_7(struct rmap_field **field_ret, const double *parameter,
                               struct rmap_error *err)
{
    const struct rmap_parameter radius = {"R", RMAP_NEED_NOT_ZERO};
    struct rmap_field *shells = NULL;
    enum rmap_status st = rmap_parameter_check("zemax 7", &radius, parameter[1], err);
    if (st == RMAP_OK)
        st = rmap_field_of_jet(&shells, &gradient_7, 1, 4, parameter, err);
    if (st != RMAP_OK)
        return st;
    struct rmap_affine to_local = rmap_affine_identity();
    to_local.t.z = -parameter[1];
    return rmap_field_placed(field_ret, shells, &to_local, err);
}

/* ---- 10: the same on both sides of y = 0 ---- */

struct folded {
    struct rmap_field base;
    struct rmap_field *of;
};

static bool folded_at(const struct rmap_field *field, int channel, struct rmap_vec3 p, double *n,
                      struct rmap_vec3 *gradient)
{
    const struct folded *self = (const struct folded *)(const void *)field;
    struct rmap_vec3 above = {p.x, fabs(p.y), p.z};
    if (!rmap_field_scalar(self->of, channel, above, n, gradient))
        return false;
    gradient->y = p.y < 0.0 ? -gradient->y : gradient->y;
    return true;
}

static bool folded_laplacian(const struct rmap_field *field, int channel, struct rmap_vec3 p,
                             double *laplacian)
{
    const struct folded *self = (const struct folded *)(const void *)field;
    return rmap_field_laplacian(self->of, channel, rmap_vec3(p.x, fabs(p.y), p.z), laplacian);
}

static void folded_destroy(struct rmap_field *field)
{
    rmap_field_destroy(((struct folded *)(void *)field)->of);
    rmap_free(field);
}

static const struct rmap_field_ops folded_ops = {"zemax 10", folded_at, folded_laplacian,
                                                 rmap_field_best_step, folded_destroy};

static enum rmap_status make_10(struct rmap_field **field_ret, const double *parameter,
                                struct rmap_error *err)
{
    enum { N_TERM = 7 };
    int power[N_TERM][3] = {{0, 0, 0}};
    for (int i = 0; i < N_TERM; i++)
        power[i][1] = i;
    struct folded *self =
        (struct folded *)(void *)rmap_field_new(sizeof *self, &folded_ops, 1, err);
    if (!self)
        return RMAP_SYSTEM;
    enum rmap_status st = rmap_field_polynomial(&self->of, RMAP_SERIES_OF_N, 1, N_TERM,
                                                (const int(*)[3])power, parameter, err);
    if (st != RMAP_OK) {
        rmap_field_destroy(&self->base);
        return st;
    }
    self->base.may_be_missing = true;
    *field_ret = &self->base;
    return RMAP_OK;
}

/* ---- 3, 5: a series in r^2 and one in z; 4, 12: one in each coordinate ---- */

static enum rmap_status make_rod(struct rmap_field **field_ret, int n_radial, int n_axial,
                                 const double *parameter, struct rmap_error *err)
{
    double axial[5] = {0.0};
    struct rmap_field *term[2] = {NULL, NULL};
    memcpy(axial + 1, parameter + n_radial, (size_t)n_axial * sizeof *axial);
    enum rmap_status st = rmap_field_series(&term[0], RMAP_SERIES_RHO2, RMAP_SERIES_OF_N, 1,
                                            n_radial, parameter, err);
    if (st == RMAP_OK)
        st = rmap_field_series(&term[1], RMAP_SERIES_Z, RMAP_SERIES_OF_N, 1, n_axial + 1, axial,
                               err);
    if (st == RMAP_OK)
        return rmap_field_sum(field_ret, 0.0, 2, term, NULL, err);
    rmap_field_destroy(term[0]);
    return st;
}

/* n_power powers of each coordinate; by_axis: x, x^2, ..., y, ... (4), else x, y, z, x^2, ... (12)
 */
enum order { BY_AXIS, BY_POWER };

static enum rmap_status make_separable(struct rmap_field **field_ret, enum order order, int n_power,
                                       const double *parameter, struct rmap_error *err)
{
    int power[RMAP_ZEMAX_PARAMETER_MAX][3] = {{0, 0, 0}};
    int last = 0;
    for (int i = 0; i < 3 * n_power; i++) {
        power[1 + i][order == BY_AXIS ? i / n_power : i % 3] =
            1 + (order == BY_AXIS ? i % n_power : i / 3);
        last = parameter[1 + i] != 0.0 ? 1 + i : last;
    }
    return rmap_field_polynomial(field_ret, RMAP_SERIES_OF_N, 1, last + 1, (const int(*)[3])power,
                                 parameter, err);
}

/* ---- 6, 9: coefficients over the wavelength ---- */

/* kept: [5] of one wavelength. Number of them. */
static int coefficients(int type, double wavelength_nm, const double *parameter, double kept[5])
{
    if (type == 6) {
        double l2 = wavelength_nm * wavelength_nm;
        for (int i = 0; i < 5; i++) {
            const double *of = parameter + 4 * (size_t)i;
            kept[i] = of[0] + of[1] * l2 + (of[2] + of[3] / l2) / l2;
        }
        return 5;
    }
    double l2 = wavelength_nm * wavelength_nm * 1e-6;
    double root = parameter[2] + (parameter[3] + parameter[4] / l2) / l2;
    kept[0] = parameter[0] + parameter[1] / l2;
    kept[1] = -0.5 * kept[0] * root * root;
    return 2;
}

static enum rmap_status make_dispersive(struct rmap_field **field_ret, int type, int n_channel,
                                        const double *wavelength_nm, const double *parameter,
                                        struct rmap_error *err)
{
    double *kept = rmap_alloc((size_t)n_channel, 5 * sizeof(double));
    if (!kept)
        return rmap_error_set(err, RMAP_SYSTEM, "zemax: no memory");
    int n = 0;
    for (int c = 0; c < n_channel; c++)
        n = coefficients(type, wavelength_nm[c], parameter, kept + (size_t)c * (size_t)n);
    enum rmap_status st =
        rmap_field_series(field_ret, RMAP_SERIES_RHO2, RMAP_SERIES_OF_N, n_channel, n, kept, err);
    rmap_free(kept);
    return st;
}

enum rmap_status rmap_field_zemax(struct rmap_field **field_ret, int type, int n_channel,
                                  const double *wavelength_nm,
                                  const double parameter[RMAP_ZEMAX_PARAMETER_MAX],
                                  struct rmap_error *err)
{
    for (int i = 0; rmap_zemax_parameter(type, i); i++) {
        const struct rmap_parameter finite = {rmap_zemax_parameter(type, i), RMAP_NEED_FINITE};
        enum rmap_status st = rmap_parameter_check("zemax", &finite, parameter[i], err);
        if (st != RMAP_OK)
            return st;
    }
    switch (type) {
    case 1:
        return rmap_field_of_jet(field_ret, &gradient_1, 1, 3, parameter, err);
    case 2:
        return rmap_field_series(field_ret, RMAP_SERIES_RHO2, RMAP_SERIES_OF_N_SQUARED, 1, 7,
                                 parameter, err);
    case 3:
        return make_rod(field_ret, 4, 3, parameter, err);
    case 4:
        return make_separable(field_ret, BY_AXIS, 2, parameter, err);
    case 5:
        return make_rod(field_ret, 3, 4, parameter, err);
    case 6:
    case 9:
        return make_dispersive(field_ret, type, n_channel, wavelength_nm, parameter, err);
    case 7:
        return make_7(field_ret, parameter, err);
    case 10:
        return make_10(field_ret, parameter, err);
    case 12:
        return make_separable(field_ret, BY_POWER, 20, parameter, err);
    default:
        return rmap_error_set(err, RMAP_INPUT,
                              "zemax: no gradient %d; there are 1 to 7, 9, 10 and 12", type);
    }
}
