/* SPDX-License-Identifier: MIT
 *
 * Fields made of fields: sums, dispersion on top, a frame of their own.
 */
#include "gradient/field_made.h"
#include "base/alloc.h"
#include "gradient/field_internal.h"

/* ---- Sums ---- */

struct sum {
    struct rmap_field base;
    double offset; /* base (1 - sum of the weights) */
    int n_term;
    struct term {
        struct rmap_field *field;
        double weight;
    } term[];
};

static const struct sum *sum_of(const struct rmap_field *field)
{
    return (const struct sum *)(const void *)field;
}

static bool sum_at(const struct rmap_field *field, int channel, struct rmap_vec3 p, double *n,
                   struct rmap_vec3 *gradient)
{
    const struct sum *self = sum_of(field);
    *n = self->offset;
    *gradient = rmap_vec3(0, 0, 0);
    for (int i = 0; i < self->n_term; i++) {
        double part;
        struct rmap_vec3 slope;
        if (!rmap_field_scalar(self->term[i].field, channel, p, &part, &slope))
            return false;
        *n += self->term[i].weight * part;
        *gradient = rmap_axpy(self->term[i].weight, slope, *gradient);
    }
    return true;
}

static bool sum_laplacian(const struct rmap_field *field, int channel, struct rmap_vec3 p,
                          double *laplacian)
{
    const struct sum *self = sum_of(field);
    *laplacian = 0.0;
    for (int i = 0; i < self->n_term; i++) {
        double part;
        if (!rmap_field_laplacian(self->term[i].field, channel, p, &part))
            return false;
        *laplacian += self->term[i].weight * part;
    }
    return true;
}

/* The most impatient term decides. */
static double sum_best_step(const struct rmap_field *field, struct rmap_vec3 p,
                            struct rmap_vec3 direction)
{
    const struct sum *self = sum_of(field);
    double step = rmap_field_best_step(field, p, direction);
    for (int i = 0; i < self->n_term; i++)
        if (self->term[i].field->ops->best_step)
            step =
                fmin(step, self->term[i].field->ops->best_step(self->term[i].field, p, direction));
    return step;
}

static void sum_destroy(struct rmap_field *field)
{
    struct sum *self = (struct sum *)(void *)field;
    for (int i = 0; i < self->n_term; i++)
        rmap_field_destroy(self->term[i].field);
    rmap_free(self);
}

static const struct rmap_field_ops sum_ops = {"sum", sum_at, sum_laplacian, sum_best_step,
                                              sum_destroy};

static enum rmap_status sum_make(struct rmap_field **field_ret, double base, int n_term,
                                 struct rmap_field *const *term, const double *weight,
                                 struct rmap_error *err)
{
    const struct rmap_parameter finite = {"a weight", RMAP_NEED_FINITE};
    double left = 1.0;
    int n_channel = 1;
    bool may_be_missing = false;
    if (n_term < 1)
        return rmap_error_set(err, RMAP_INPUT, "sum: give at least one term");
    for (int i = 0; i < n_term; i++) {
        enum rmap_status st = rmap_parameter_check("sum", &finite, weight ? weight[i] : 1.0, err);
        if (st != RMAP_OK)
            return st;
        left -= weight ? weight[i] : 1.0;
        if (term[i]->n_channel > n_channel)
            n_channel = term[i]->n_channel;
        may_be_missing = may_be_missing || term[i]->may_be_missing;
    }
    struct sum *self = (struct sum *)(void *)rmap_field_new(
        sizeof(struct sum) + (size_t)n_term * sizeof(struct term), &sum_ops, n_channel, err);
    if (!self)
        return RMAP_SYSTEM;
    self->offset = base * left;
    self->n_term = n_term;
    self->base.may_be_missing = may_be_missing;
    for (int i = 0; i < n_term; i++)
        self->term[i] = (struct term){term[i], weight ? weight[i] : 1.0};
    *field_ret = &self->base;
    return RMAP_OK;
}

enum rmap_status rmap_field_sum(struct rmap_field **field_ret, double base, int n_term,
                                struct rmap_field *const *term, const double *weight,
                                struct rmap_error *err)
{
    enum rmap_status st = sum_make(field_ret, base, n_term, term, weight, err);
    for (int i = 0; st != RMAP_OK && i < n_term; i++)
        rmap_field_destroy(term[i]);
    return st;
}

/* ---- Dispersion on top ---- */

struct dispersed {
    struct rmap_field base;
    struct rmap_field *of;
    struct rmap_dispersed parameter[]; /* [n_channel] */
};

static const struct dispersed *dispersed_of(const struct rmap_field *field)
{
    return (const struct dispersed *)(const void *)field;
}

static bool dispersed_at(const struct rmap_field *field, int channel, struct rmap_vec3 p, double *n,
                         struct rmap_vec3 *gradient)
{
    const struct dispersed *self = dispersed_of(field);
    const struct rmap_dispersed *parameter = &self->parameter[channel];
    if (!rmap_field_scalar(self->of, channel, p, n, gradient))
        return false;
    *n = 1.0 + (parameter->scale * (*n - 1.0) + parameter->offset);
    *gradient = rmap_scale(*gradient, parameter->scale);
    return true;
}

static bool dispersed_laplacian(const struct rmap_field *field, int channel, struct rmap_vec3 p,
                                double *laplacian)
{
    const struct dispersed *self = dispersed_of(field);
    if (!rmap_field_laplacian(self->of, channel, p, laplacian))
        return false;
    *laplacian *= self->parameter[channel].scale;
    return true;
}

static double dispersed_best_step(const struct rmap_field *field, struct rmap_vec3 p,
                                  struct rmap_vec3 direction)
{
    const struct rmap_field *of = dispersed_of(field)->of;
    return of->ops->best_step ? of->ops->best_step(of, p, direction)
                              : rmap_field_best_step(field, p, direction);
}

static void dispersed_destroy(struct rmap_field *field)
{
    rmap_field_destroy(((struct dispersed *)(void *)field)->of);
    rmap_free(field);
}

static const struct rmap_field_ops dispersed_ops = {"dispersed", dispersed_at, dispersed_laplacian,
                                                    dispersed_best_step, dispersed_destroy};

static enum rmap_status dispersed_make(struct rmap_field **field_ret, struct rmap_field *of,
                                       int n_channel, const struct rmap_dispersed *parameter,
                                       struct rmap_error *err)
{
    const struct rmap_parameter scale = {"scale", RMAP_NEED_NOT_ZERO},
                                offset = {"offset", RMAP_NEED_FINITE};
    for (int c = 0; c < n_channel; c++) {
        enum rmap_status st = rmap_parameter_check("dispersion", &scale, parameter[c].scale, err);
        if (st == RMAP_OK)
            st = rmap_parameter_check("dispersion", &offset, parameter[c].offset, err);
        if (st != RMAP_OK)
            return st;
    }
    struct dispersed *self = (struct dispersed *)(void *)rmap_field_new(
        sizeof(struct dispersed) + (size_t)n_channel * sizeof *parameter, &dispersed_ops, n_channel,
        err);
    if (!self)
        return RMAP_SYSTEM;
    self->of = of;
    self->base.may_be_missing = of->may_be_missing;
    for (int c = 0; c < n_channel; c++)
        self->parameter[c] = parameter[c];
    *field_ret = &self->base;
    return RMAP_OK;
}

enum rmap_status rmap_field_dispersed(struct rmap_field **field_ret, struct rmap_field *of,
                                      int n_channel, const struct rmap_dispersed *parameter,
                                      struct rmap_error *err)
{
    enum rmap_status st = dispersed_make(field_ret, of, n_channel, parameter, err);
    if (st != RMAP_OK)
        rmap_field_destroy(of);
    return st;
}

/* ---- A frame of its own ---- */

struct placed {
    struct rmap_field base;
    struct rmap_field *of;
    struct rmap_affine to_local;
};

static bool placed_at(const struct rmap_field *field, int channel, struct rmap_vec3 p, double *n,
                      struct rmap_vec3 *gradient)
{
    const struct placed *self = (const struct placed *)(const void *)field;
    if (!rmap_field_scalar(self->of, channel, rmap_affine_point(&self->to_local, p), n, gradient))
        return false;
    *gradient = rmap_affine_transposed(&self->to_local, *gradient);
    return true;
}

static bool placed_quadratic(const struct rmap_field *field, int channel, double bend[3][3])
{
    const struct placed *self = (const struct placed *)(const void *)field;
    if (!rmap_field_quadratic(self->of, channel, bend))
        return false;
    rmap_affine_congruent(&self->to_local, bend);
    return true;
}

static void placed_destroy(struct rmap_field *field)
{
    rmap_field_destroy(((struct placed *)(void *)field)->of);
    rmap_free(field);
}

/* The Laplacian of a stretched field needs more of it than its own: by differences. */
static const struct rmap_field_ops placed_ops = {.model = "placed",
                                                 .at = placed_at,
                                                 .best_step = rmap_field_best_step,
                                                 .quadratic = placed_quadratic,
                                                 .destroy = placed_destroy};

enum rmap_status rmap_field_placed(struct rmap_field **field_ret, struct rmap_field *of,
                                   const struct rmap_affine *to_local, struct rmap_error *err)
{
    struct placed *self =
        (struct placed *)(void *)rmap_field_new(sizeof *self, &placed_ops, of->n_channel, err);
    if (!self) {
        rmap_field_destroy(of);
        return RMAP_SYSTEM;
    }
    self->of = of;
    self->to_local = *to_local;
    self->base.may_be_missing = of->may_be_missing;
    *field_ret = &self->base;
    return RMAP_OK;
}
