/* SPDX-License-Identifier: MIT
 *
 * Fields of one coordinate: what every such model shares.
 */
#include <string.h>

#include "base/alloc.h"
#include "gradient/field_internal.h"

struct jet_field {
    struct rmap_field base;
    struct rmap_field_ops ops; /* with the model's name */
    const struct rmap_jet_model *model;
    int n_kept;
    double kept[]; /* [n_channel][n_kept] */
};

static const struct jet_field *of(const struct rmap_field *field)
{
    return (const struct jet_field *)(const void *)field;
}

/* What of p the coordinate s is made of: s = |reach|^2, or z; grad s = 2 reach, or the z axis. */
static struct rmap_vec3 reach(const struct rmap_jet_model *model, struct rmap_vec3 p, double *s)
{
    switch (model->s) {
    case RMAP_SERIES_Z:
        *s = p.z;
        return rmap_vec3(0.0, 0.0, 0.5);
    case RMAP_SERIES_RHO2:
        p.z = 0.0;
        break;
    case RMAP_SERIES_R2:
        break;
    }
    *s = rmap_dot(p, p);
    return p;
}

static bool jet_at(const struct rmap_field *field, int channel, struct rmap_vec3 p, double *n,
                   struct rmap_vec3 *gradient)
{
    const struct jet_field *self = of(field);
    const struct rmap_jet_model *model = self->model;
    double s, jet[3];
    struct rmap_vec3 half = reach(model, p, &s);
    if (!model->jet(self->kept + (size_t)channel * (size_t)self->n_kept, self->n_kept, s, jet))
        return false;
    if (model->q == RMAP_SERIES_OF_N) {
        *n = jet[0];
        *gradient = rmap_scale(half, 2.0 * jet[1]);
        return true;
    }
    if (!(jet[0] > 0.0))
        return false;
    *n = sqrt(jet[0]);
    *gradient = rmap_scale(half, jet[1] / *n);
    return true;
}

/* Laplacian of q(s): q' lap s + q'' |grad s|^2; of n = sqrt(q): lap q / 2n - |grad q|^2 / 4n^3. */
static bool jet_laplacian(const struct rmap_field *field, int channel, struct rmap_vec3 p,
                          double *laplacian)
{
    static const double laplacian_of_s[] = {
        [RMAP_SERIES_Z] = 0.0, [RMAP_SERIES_RHO2] = 4.0, [RMAP_SERIES_R2] = 6.0};
    const struct jet_field *self = of(field);
    const struct rmap_jet_model *model = self->model;
    double s, jet[3];
    struct rmap_vec3 half = reach(model, p, &s);
    if (!model->jet(self->kept + (size_t)channel * (size_t)self->n_kept, self->n_kept, s, jet))
        return false;
    double slope2 = 4.0 * rmap_dot(half, half);
    *laplacian = jet[1] * laplacian_of_s[model->s] + jet[2] * slope2;
    if (model->q == RMAP_SERIES_OF_N)
        return isfinite(*laplacian);
    double n = sqrt(jet[0]);
    *laplacian = *laplacian / (2.0 * n) - jet[1] * jet[1] * slope2 / (4.0 * n * n * n);
    return isfinite(*laplacian);
}

/* A series of n^2 up to s, or of z up to its square; or one constant. */
static bool jet_quadratic(const struct rmap_field *field, int channel, double bend[3][3])
{
    const struct jet_field *self = of(field);
    const struct rmap_jet_model *model = self->model;
    const double *kept = self->kept + (size_t)channel * (size_t)self->n_kept;
    int axial = model->s == RMAP_SERIES_Z, last = model->q == RMAP_SERIES_OF_N ? 0 : 1 + axial;
    if (model->jet != rmap_jet_series)
        return false;
    for (int i = last + 1; i < self->n_kept; i++)
        if (kept[i] != 0.0)
            return false;
    double of_last = last > 0 && last < self->n_kept ? kept[last] : 0.0;
    memset(bend, 0, 9 * sizeof bend[0][0]);
    for (int k = axial ? 2 : 0; k < (model->s == RMAP_SERIES_RHO2 ? 2 : 3); k++)
        bend[k][k] = of_last;
    return true;
}

enum rmap_status rmap_field_of_jet(struct rmap_field **field_ret,
                                   const struct rmap_jet_model *model, int n_channel, int n_kept,
                                   const double *kept, struct rmap_error *err)
{
    size_t n = (size_t)n_channel * (size_t)n_kept;
    struct rmap_field *field =
        rmap_field_new(sizeof(struct jet_field) + n * sizeof(double), NULL, n_channel, err);
    if (!field)
        return RMAP_SYSTEM;
    struct jet_field *self = (struct jet_field *)(void *)field;
    self->ops = (struct rmap_field_ops){.model = model->model,
                                        .at = jet_at,
                                        .laplacian = jet_laplacian,
                                        .best_step = rmap_field_best_step,
                                        .quadratic = jet_quadratic};
    self->base.ops = &self->ops;
    self->base.may_be_missing = model->may_be_missing;
    self->model = model;
    self->n_kept = n_kept;
    memcpy(self->kept, kept, n * sizeof(double));
    *field_ret = field;
    return RMAP_OK;
}

enum rmap_status rmap_field_of_model(struct rmap_field **field_ret,
                                     const struct rmap_jet_model *model, int n_channel,
                                     const void *parameter, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const double *given = parameter;
    size_t n_kept = (size_t)(model->prepare ? model->n_kept : model->n_parameter);
    double *kept = rmap_alloc((size_t)n_channel * n_kept, sizeof(double));
    if (!kept)
        return rmap_error_set(err, RMAP_SYSTEM, "%s: no memory", model->model);
    for (int c = 0; c < n_channel; c++, given += model->n_parameter) {
        for (int i = 0; i < model->n_parameter; i++)
            RMAP_TRY(rmap_parameter_check(model->model, &model->parameter[i], given[i], err));
        if (model->prepare)
            model->prepare(given, kept + (size_t)c * n_kept);
        else
            memcpy(kept + (size_t)c * n_kept, given, n_kept * sizeof(double));
    }
    RMAP_TRY(rmap_field_of_jet(field_ret, model, n_channel, (int)n_kept, kept, err));
out:
    rmap_free(kept);
    return st;
}

void rmap_jet_of_radius(double r, const double f[3], double jet[3])
{
    jet[0] = f[0];
    jet[1] = f[1] / (2.0 * r);
    jet[2] = (f[2] - f[1] / r) / (4.0 * r * r);
}
