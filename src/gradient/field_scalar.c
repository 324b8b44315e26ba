/* SPDX-License-Identifier: MIT
 *
 * The index over a scalar field: temperature, density, salinity, concentration. With n = f(v):
 * grad n = f' grad v, lap n = f' lap v + f'' |grad v|^2.
 */
#include "base/alloc.h"
#include "gradient/field_internal.h"
#include "gradient/spline.h"
#include "optics/fluid.h"

struct of_scalar {
    struct rmap_field base;
    struct rmap_field *scalar;
    enum rmap_index_law law;
    struct law_parameter {
        double n0, slope, zero_k;    /* LINEAR; AIR: slope = (n - 1) T, K */
        double other, wavelength_nm; /* SEAWATER: temperature or salinity */
        struct rmap_spline table;
    } parameter[]; /* [n_channel] */
};

/* f: n, dn/dv, d2n/dv2. False where the law has no value. */
static bool law_at(enum rmap_index_law law, const struct law_parameter *parameter, double v,
                   double f[3])
{
    double derivative[3];
    switch (law) {
    case RMAP_INDEX_LINEAR:
    case RMAP_INDEX_GLADSTONE_DALE:
        f[0] = parameter->n0 + parameter->slope * v;
        f[1] = parameter->slope;
        f[2] = 0.0;
        return true;
    case RMAP_INDEX_AIR: {
        double kelvin = v + parameter->zero_k;
        if (!(kelvin > 0.0))
            return false;
        double part = parameter->slope / kelvin;
        f[0] = 1.0 + part;
        f[1] = -part / kelvin;
        f[2] = -2.0 * f[1] / kelvin;
        return true;
    }
    case RMAP_INDEX_SEAWATER_SALINITY:
        f[0] = rmap_seawater_index(v, parameter->other, parameter->wavelength_nm, derivative);
        f[1] = derivative[0];
        f[2] = 0.0;
        return true;
    case RMAP_INDEX_SEAWATER_TEMPERATURE:
        f[0] = rmap_seawater_index(parameter->other, v, parameter->wavelength_nm, derivative);
        f[1] = derivative[1];
        f[2] = derivative[2];
        return true;
    case RMAP_INDEX_TABLE:
        rmap_spline_at(&parameter->table, v, f);
        return true;
    }
    return false;
}

static const struct of_scalar *of_scalar_of(const struct rmap_field *field)
{
    return (const struct of_scalar *)(const void *)field;
}

static bool of_scalar_at(const struct rmap_field *field, int channel, struct rmap_vec3 p, double *n,
                         struct rmap_vec3 *gradient)
{
    const struct of_scalar *self = of_scalar_of(field);
    double v, f[3];
    if (!rmap_field_scalar(self->scalar, channel, p, &v, gradient) ||
        !law_at(self->law, &self->parameter[channel], v, f))
        return false;
    *n = f[0];
    *gradient = rmap_scale(*gradient, f[1]);
    return true;
}

static bool of_scalar_laplacian(const struct rmap_field *field, int channel, struct rmap_vec3 p,
                                double *laplacian)
{
    const struct of_scalar *self = of_scalar_of(field);
    double v, f[3];
    struct rmap_vec3 slope;
    if (!rmap_field_scalar(self->scalar, channel, p, &v, &slope) ||
        !rmap_field_laplacian(self->scalar, channel, p, laplacian) ||
        !law_at(self->law, &self->parameter[channel], v, f))
        return false;
    *laplacian = f[1] * *laplacian + f[2] * rmap_dot(slope, slope);
    return isfinite(*laplacian);
}

static void of_scalar_destroy(struct rmap_field *field)
{
    struct of_scalar *self = (struct of_scalar *)(void *)field;
    for (int c = 0; c < field->n_channel; c++)
        rmap_spline_fini(&self->parameter[c].table);
    rmap_field_destroy(self->scalar);
    rmap_free(self);
}

static const struct rmap_field_ops of_scalar_ops = {"index of a scalar", of_scalar_at,
                                                    of_scalar_laplacian, rmap_field_best_step,
                                                    of_scalar_destroy};

static enum rmap_status check(const struct rmap_parameter *name, double value,
                              struct rmap_error *err)
{
    return rmap_parameter_check("index", name, value, err);
}

static enum rmap_status prepare_air(struct law_parameter *kept, double wavelength_nm,
                                    const struct rmap_index_of *given, struct rmap_error *err)
{
    enum rmap_status st;
    double refractivity = rmap_air_refractivity(wavelength_nm);
    RMAP_TRY(
        check(&(struct rmap_parameter){"pressure", RMAP_NEED_POSITIVE}, given->pressure_pa, err));
    RMAP_TRY(check(&(struct rmap_parameter){"zero_k", RMAP_NEED_FINITE}, given->zero_k, err));
    RMAP_TRY(check(
        &(struct rmap_parameter){"the refractivity of air at this wavelength", RMAP_NEED_POSITIVE},
        refractivity, err));
    kept->slope = refractivity * RMAP_AIR_STANDARD_K * given->pressure_pa / RMAP_AIR_STANDARD_PA;
    kept->zero_k = given->zero_k;
out:
    return st;
}

static enum rmap_status prepare(struct law_parameter *kept, double wavelength_nm,
                                const struct rmap_index_of *given, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    kept->wavelength_nm = wavelength_nm;
    switch (given->law) {
    case RMAP_INDEX_LINEAR:
        RMAP_TRY(check(&(struct rmap_parameter){"n0", RMAP_NEED_FINITE}, given->n0, err));
        RMAP_TRY(check(&(struct rmap_parameter){"slope", RMAP_NEED_FINITE}, given->slope, err));
        kept->n0 = given->n0;
        kept->slope = given->slope;
        break;
    case RMAP_INDEX_GLADSTONE_DALE:
        RMAP_TRY(check(&(struct rmap_parameter){"n0", RMAP_NEED_POSITIVE}, given->n0, err));
        RMAP_TRY(check(&(struct rmap_parameter){"reference", RMAP_NEED_POSITIVE}, given->reference,
                       err));
        kept->n0 = 1.0;
        kept->slope = (given->n0 - 1.0) / given->reference;
        break;
    case RMAP_INDEX_AIR:
        return prepare_air(kept, wavelength_nm, given, err);
    case RMAP_INDEX_SEAWATER_SALINITY:
        kept->other = given->temperature_c;
        return check(&(struct rmap_parameter){"temperature", RMAP_NEED_FINITE}, kept->other, err);
    case RMAP_INDEX_SEAWATER_TEMPERATURE:
        kept->other = given->salinity;
        return check(&(struct rmap_parameter){"salinity", RMAP_NEED_NOT_NEGATIVE}, kept->other,
                     err);
    case RMAP_INDEX_TABLE:
        return rmap_spline_init(&kept->table, "index table", given->n_point, given->at, given->n,
                                RMAP_SPLINE_NATURAL, err);
    }
out:
    return st;
}

enum rmap_status rmap_field_of_scalar(struct rmap_field **field_ret, struct rmap_field *scalar,
                                      int n_channel, const double *wavelength_nm,
                                      const struct rmap_index_of *parameter, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct of_scalar *self = (struct of_scalar *)(void *)rmap_field_new(
        sizeof(struct of_scalar) + (size_t)n_channel * sizeof(struct law_parameter), &of_scalar_ops,
        n_channel, err);
    if (!self) {
        rmap_field_destroy(scalar);
        return RMAP_SYSTEM;
    }
    self->scalar = scalar;
    self->law = parameter[0].law;
    self->base.may_be_missing = true;
    for (int c = 0; c < n_channel; c++)
        RMAP_TRY(prepare(&self->parameter[c], wavelength_nm[c], &parameter[c], err));
    *field_ret = &self->base;
    self = NULL;
out:
    rmap_field_destroy(self ? &self->base : NULL);
    return st;
}
