/* SPDX-License-Identifier: MIT
 *
 * Makers of the analytic index fields that are no polynomials (field_polynomial.h has those).
 */
#include "base/alloc.h"
#include "gradient/field_internal.h"
#include "gradient/spline.h"
#include "optics/fluid.h"

/* Exponential atmospheres, flat or round; with a negative refractivity the hot layer over a road.
 */

/* f, df/dh, d2f/dh2; parameter: {n_far, refractivity, scale_height, radius} */
static void fall(const double *parameter, double h, double f[3])
{
    /* Far below the ground, where no light comes, it stays a number: a body may reach there. */
    double part = parameter[1] * exp(fmin(-h / parameter[2], 300.0));
    f[0] = parameter[0] + part;
    f[1] = -part / parameter[2];
    f[2] = -f[1] / parameter[2];
}

static bool jet_flat(const double *parameter, int n_parameter, double s, double jet[3])
{
    (void)n_parameter;
    fall(parameter, s, jet);
    return true;
}

/* Heights are differences of r: at r = 6.4e6 m they hold 1e-9 m, so n - 1 its 13 digits. */
static bool jet_round(const double *parameter, int n_parameter, double s, double jet[3])
{
    (void)n_parameter;
    if (!(s > 0.0))
        return false;
    double f[3], r = sqrt(s);
    fall(parameter, r - parameter[3], f);
    rmap_jet_of_radius(r, f, jet);
    return true;
}

#define EXPONENTIAL(s_of, jet_of)                                                                  \
    {                                                                                              \
        .model = "exponential", .s = (s_of), .q = RMAP_SERIES_OF_N, .jet = (jet_of),               \
        .may_be_missing = true, .n_parameter = 4, .parameter = {                                   \
            {"n_far", RMAP_NEED_POSITIVE},                                                         \
            {"refractivity", RMAP_NEED_FINITE},                                                    \
            {"scale_height", RMAP_NEED_NOT_ZERO},                                                  \
            {"radius", RMAP_NEED_NOT_NEGATIVE}                                                     \
        }                                                                                          \
    }

static const struct rmap_jet_model flat = EXPONENTIAL(RMAP_SERIES_Z, jet_flat);
static const struct rmap_jet_model round_one = EXPONENTIAL(RMAP_SERIES_R2, jet_round);

enum rmap_status rmap_field_exponential(struct rmap_field **field_ret, int n_channel,
                                        const struct rmap_exponential *parameter,
                                        struct rmap_error *err)
{
    for (int c = 1; c < n_channel; c++)
        if (parameter[c].radius != parameter[0].radius)
            return rmap_error_set(err, RMAP_INPUT,
                                  "exponential: radius differs between wavelengths; give one");
    return rmap_field_of_model(field_ret, parameter[0].radius == 0.0 ? &flat : &round_one,
                               n_channel, parameter, err);
}

/* The hyperbolic-secant rod (Fletcher, Murphy & Young 1954, Proc. R. Soc. A 223, 216): meridional
 * light of every height has the same period 2 pi / alpha. */

/* With u = (alpha rho)^2 below this the second derivative's difference of two near-equal numbers
 * would lose more than the series 5/12 - 61/120 u + 1385/3360 u^2 leaves out. */
#define SMALL 1e-3

/* parameter: {n0, alpha} */
static bool jet_sech(const double *parameter, int n_parameter, double s, double jet[3])
{
    (void)n_parameter;
    double alpha2 = parameter[1] * parameter[1], u = alpha2 * s, x = sqrt(u);
    double n = parameter[0] / cosh(x), t = tanh(x);
    double ratio = x > 0.0 ? t / x : 1.0;
    jet[0] = n;
    jet[1] = -0.5 * n * alpha2 * ratio;
    double second = u < SMALL
                        ? parameter[0] * (5.0 / 12.0 + u * (-61.0 / 120.0 + u * 1385.0 / 3360.0))
                        : n * (2.0 * t * t - 1.0 + ratio) / (4.0 * u);
    jet[2] = alpha2 * alpha2 * second;
    return true;
}

static const struct rmap_jet_model sech = {
    .model = "sech",
    .s = RMAP_SERIES_RHO2,
    .q = RMAP_SERIES_OF_N,
    .jet = jet_sech,
    .n_parameter = 2,
    .parameter = {{"n0", RMAP_NEED_POSITIVE}, {"alpha", RMAP_NEED_FINITE}}};

enum rmap_status rmap_field_sech(struct rmap_field **field_ret, int n_channel,
                                 const struct rmap_sech *parameter, struct rmap_error *err)
{
    return rmap_field_of_model(field_ret, &sech, n_channel, parameter, err);
}

/* The index over a scalar field: temperature, density, salinity, concentration. With n = f(v):
 * grad n = f' grad v, lap n = f' lap v + f'' |grad v|^2. */

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

/* Eaton's lens (Eaton 1952, IRE Trans. Antennas Propag. 4, 66): light goes in Kepler ellipses about
 * the centre and comes back the way it came. */

/* n^2 = n_edge^2 (2 R / r - 1); parameter: {n_edge^2, 2 R} */
static bool jet_eaton(const double *parameter, int n_parameter, double s, double jet[3])
{
    (void)n_parameter;
    if (!(s > 0.0))
        return false;
    double pull = parameter[0] * parameter[1] / sqrt(s);
    jet[0] = pull - parameter[0];
    jet[1] = -0.5 * pull / s;
    jet[2] = 0.75 * pull / (s * s);
    return true;
}

static void prepare_eaton(const double *given, double *kept)
{
    kept[0] = given[0] * given[0];
    kept[1] = 2.0 * given[1];
}

static const struct rmap_jet_model eaton = {
    .model = "eaton",
    .s = RMAP_SERIES_R2,
    .q = RMAP_SERIES_OF_N_SQUARED,
    .jet = jet_eaton,
    .may_be_missing = true,
    .n_parameter = 2,
    .parameter = {{"n_edge", RMAP_NEED_POSITIVE}, {"radius", RMAP_NEED_POSITIVE}},
    .prepare = prepare_eaton,
    .n_kept = 2};

enum rmap_status rmap_field_eaton(struct rmap_field **field_ret, int n_channel,
                                  const struct rmap_eaton *parameter, struct rmap_error *err)
{
    return rmap_field_of_model(field_ret, &eaton, n_channel, parameter, err);
}

/* Maxwell's fish-eye (1854; Born & Wolf, Principles of Optics, 7th ed., 4.2.2): light goes in
 * circles, every point has a perfect image. */

/* parameter: {n_centre, 1 / radius^2} */
static bool jet_maxwell(const double *parameter, int n_parameter, double s, double jet[3])
{
    (void)n_parameter;
    double k = parameter[1], scale = 1.0 / (1.0 + k * s);
    jet[0] = parameter[0] * scale;
    jet[1] = -k * scale * jet[0];
    jet[2] = -2.0 * k * scale * jet[1];
    return true;
}

static void prepare_maxwell(const double *given, double *kept)
{
    kept[0] = given[0];
    kept[1] = 1.0 / (given[1] * given[1]);
}

static const struct rmap_jet_model maxwell = {
    .model = "maxwell",
    .s = RMAP_SERIES_R2,
    .q = RMAP_SERIES_OF_N,
    .jet = jet_maxwell,
    .n_parameter = 2,
    .parameter = {{"n_centre", RMAP_NEED_POSITIVE}, {"radius", RMAP_NEED_POSITIVE}},
    .prepare = prepare_maxwell,
    .n_kept = 2};

enum rmap_status rmap_field_maxwell(struct rmap_field **field_ret, int n_channel,
                                    const struct rmap_maxwell *parameter, struct rmap_error *err)
{
    return rmap_field_of_model(field_ret, &maxwell, n_channel, parameter, err);
}

/* n over a coordinate by a spline, or its logarithm of n - 1 (the standard atmosphere). */

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
