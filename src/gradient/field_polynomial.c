/* SPDX-License-Identifier: MIT
 *
 * Polynomials in x, y, z, of n or of n^2.
 */
#include <string.h>

#include "base/alloc.h"
#include "gradient/field_internal.h"

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
