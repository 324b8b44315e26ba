/* SPDX-License-Identifier: MIT
 *
 * n over a coordinate by a spline, or its logarithm of n - 1 (the standard atmosphere).
 */
#include "base/alloc.h"
#include "gradient/field_internal.h"
#include "gradient/spline.h"
#include "optics/fluid.h"

enum of { OF_N, OF_LOG_REFRACTIVITY };

struct profile {
    struct rmap_field base;
    enum rmap_profile_variable s;
    enum of of;
    double radius;
    struct rmap_spline spline[]; /* [n_channel] */
};

static const struct profile *profile_of(const struct rmap_field *field)
{
    return (const struct profile *)(const void *)field;
}

/* Index and its derivatives along the coordinate; the coordinate's direction and distance from its
 * centre (INFINITY for z). */
static void along(const struct profile *self, int channel, struct rmap_vec3 p, double f[3],
                  struct rmap_vec3 *towards, double *distance)
{
    if (self->s == RMAP_PROFILE_RHO)
        p.z = 0.0;
    *distance = self->s == RMAP_PROFILE_Z ? (double)INFINITY : rmap_length(p);
    *towards = self->s == RMAP_PROFILE_Z ? rmap_vec3(0, 0, 1)
               : *distance > 0.0         ? rmap_scale(p, 1.0 / *distance)
                                         : rmap_vec3(0, 0, 0);
    double at = self->s == RMAP_PROFILE_Z ? p.z : *distance - self->radius;
    rmap_spline_at(&self->spline[channel], at, f);
    if (self->of == OF_N)
        return;
    double part = exp(f[0]);
    f[2] = part * (f[2] + f[1] * f[1]);
    f[1] = part * f[1];
    f[0] = 1.0 + part;
}

static bool profile_at(const struct rmap_field *field, int channel, struct rmap_vec3 p, double *n,
                       struct rmap_vec3 *gradient)
{
    double f[3], distance;
    struct rmap_vec3 towards;
    along(profile_of(field), channel, p, f, &towards, &distance);
    *n = f[0];
    *gradient = rmap_scale(towards, f[1]);
    return true;
}

static bool profile_laplacian(const struct rmap_field *field, int channel, struct rmap_vec3 p,
                              double *laplacian)
{
    static const double across[] = {
        [RMAP_PROFILE_Z] = 0.0, [RMAP_PROFILE_RHO] = 1.0, [RMAP_PROFILE_R] = 2.0};
    const struct profile *self = profile_of(field);
    double f[3], distance;
    struct rmap_vec3 towards;
    along(self, channel, p, f, &towards, &distance);
    *laplacian = f[2] + across[self->s] * (distance > 0.0 ? f[1] / distance : f[2]);
    return isfinite(*laplacian);
}

static void profile_destroy(struct rmap_field *field)
{
    struct profile *self = (struct profile *)(void *)field;
    for (int c = 0; c < field->n_channel; c++)
        rmap_spline_fini(&self->spline[c]);
    rmap_free(self);
}

static const struct rmap_field_ops profile_ops = {"profile", profile_at, profile_laplacian,
                                                  rmap_field_best_step, profile_destroy};
static const struct rmap_field_ops air_ops = {"standard_air", profile_at, profile_laplacian,
                                              rmap_field_best_step, profile_destroy};

static struct profile *profile_new(const struct rmap_field_ops *ops, int n_channel,
                                   struct rmap_error *err)
{
    return (struct profile *)(void *)rmap_field_new(
        sizeof(struct profile) + (size_t)n_channel * sizeof(struct rmap_spline), ops, n_channel,
        err);
}

enum rmap_status rmap_field_profile(struct rmap_field **field_ret, enum rmap_profile_variable s,
                                    double radius, int n_channel, int n_point, const double *at,
                                    const double *n, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_parameter not_negative = {"radius", RMAP_NEED_NOT_NEGATIVE};
    struct profile *self = profile_new(&profile_ops, n_channel, err);
    if (!self)
        return RMAP_SYSTEM;
    RMAP_TRY(rmap_parameter_check("profile", &not_negative, radius, err));
    bool centred = s == RMAP_PROFILE_RHO || (s == RMAP_PROFILE_R && radius == 0.0);
    if (centred && n_point > 0 && at[0] < 0.0) {
        st = rmap_error_set(err, RMAP_INPUT,
                            "profile: the first point is at %g; distances from a centre are >= 0",
                            at[0]);
        goto out;
    }
    self->s = s;
    self->radius = s == RMAP_PROFILE_R ? radius : 0.0;
    self->base.may_be_missing = true;
    bool even = centred && n_point > 0 && at[0] == 0.0;
    for (int c = 0; c < n_channel; c++)
        RMAP_TRY(rmap_spline_init(&self->spline[c], "profile", n_point, at,
                                  n + (size_t)c * (size_t)n_point,
                                  even ? RMAP_SPLINE_EVEN : RMAP_SPLINE_NATURAL, err));
    *field_ret = &self->base;
    self = NULL;
out:
    rmap_field_destroy(self ? &self->base : NULL);
    return st;
}

/* Knots every 100 m: the temperature's kinks between layers are rounded within that. */
#define AIR_KNOT_M  100.0
#define AIR_TOP_M   86000.0
#define AIR_N_POINT 861

static enum rmap_status check_air(int n_channel, const double *wavelength_nm,
                                  const struct rmap_standard_air *parameter, struct rmap_error *err)
{
    const struct rmap_parameter name[] = {{"radius", RMAP_NEED_NOT_NEGATIVE},
                                          {"metre", RMAP_NEED_POSITIVE},
                                          {"temperature", RMAP_NEED_POSITIVE},
                                          {"pressure", RMAP_NEED_POSITIVE}};
    const double value[] = {parameter->radius, parameter->metre, parameter->temperature_k,
                            parameter->pressure_pa};
    for (size_t i = 0; i < sizeof name / sizeof name[0]; i++) {
        enum rmap_status st = rmap_parameter_check("standard_air", &name[i], value[i], err);
        if (st != RMAP_OK)
            return st;
    }
    /* The coldest layer of the standard column, 186.87 K at 84.852 km, must stay one. */
    if (parameter->temperature_k < RMAP_AIR_STANDARD_K - 150.0)
        return rmap_error_set(err, RMAP_INPUT,
                              "standard_air: %g K on the ground leaves no air at 85 km; give at "
                              "least %g",
                              parameter->temperature_k, RMAP_AIR_STANDARD_K - 150.0);
    for (int c = 0; c < n_channel; c++)
        if (!(rmap_air_refractivity(wavelength_nm[c]) > 0.0))
            return rmap_error_set(err, RMAP_INPUT,
                                  "standard_air: no index of air at %g nm; from 185 nm on",
                                  wavelength_nm[c]);
    return RMAP_OK;
}

enum rmap_status rmap_field_standard_air(struct rmap_field **field_ret, int n_channel,
                                         const double *wavelength_nm,
                                         const struct rmap_standard_air *parameter,
                                         struct rmap_error *err)
{
    struct profile *self = NULL;
    double *knot = NULL;
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(check_air(n_channel, wavelength_nm, parameter, err));
    self = profile_new(&air_ops, n_channel, err);
    knot = rmap_alloc(AIR_N_POINT, 2 * sizeof(double));
    if (!self || !knot) {
        st = rmap_error_set(err, RMAP_SYSTEM, "standard_air: no memory");
        goto out;
    }
    self->s = parameter->radius > 0.0 ? RMAP_PROFILE_R : RMAP_PROFILE_Z;
    self->of = OF_LOG_REFRACTIVITY;
    self->radius = parameter->radius;
    double *log_refractivity = knot + AIR_N_POINT;
    double shift_k = parameter->temperature_k - RMAP_AIR_STANDARD_K;
    double ground = parameter->pressure_pa / RMAP_AIR_STANDARD_PA * RMAP_AIR_STANDARD_K /
                    parameter->temperature_k;
    for (int c = 0; c < n_channel; c++) {
        double refractivity = ground * rmap_air_refractivity(wavelength_nm[c]);
        for (int i = 0; i < AIR_N_POINT; i++) {
            double height_m = fmin(i * AIR_KNOT_M, AIR_TOP_M);
            knot[i] = height_m * parameter->metre;
            log_refractivity[i] = log(refractivity * rmap_standard_density(height_m, shift_k));
        }
        RMAP_TRY(rmap_spline_init(&self->spline[c], "standard_air", AIR_N_POINT, knot,
                                  log_refractivity, RMAP_SPLINE_NATURAL, err));
    }
    *field_ret = &self->base;
    self = NULL;
out:
    rmap_free(knot);
    rmap_field_destroy(self ? &self->base : NULL);
    return st;
}
