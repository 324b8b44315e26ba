/* SPDX-License-Identifier: MIT
 *
 * Lobes about the specular direction (RETRO: about the way back), or about the normal (LAMBERT,
 * OREN_NAYAR).
 */
#include "scatter/lobe.h"

#include "base/portable.h"
#include "formula/azimuth.h"
#include "scatter/dust.h"
#include "scatter/table.h"

static double derived_of(const struct rmap_scattering *at, int k)
{
    return at->scatter->derived[k][at->channel];
}

/* By roughness, l is that of the medium the light is in. */
static double width_of(const struct rmap_scattering *at)
{
    double l = rmap_lobe_number(at, RMAP_SHAPE_L);
    return at->scatter->by_roughness ? l / (at->passes ? at->n2 : at->n1) : l;
}

/* Radial lobes, functions of x. The power of Harvey's law is s, of K-correlation -s. */

static double power_of(const struct rmap_scattering *at)
{
    double s = rmap_lobe_number(at, RMAP_SHAPE_S);
    return at->scatter->model == RMAP_SCATTER_HARVEY ? s : -s;
}

static double raised(double x, double exponent, bool portable)
{
    return portable ? rmap_portable_power(x, exponent) : pow(x, exponent);
}

double rmap_lobe_radial(const struct rmap_scattering *at, double x, bool portable)
{
    double y;
    switch (at->scatter->model) {
    case RMAP_SCATTER_GAUSSIAN:
    case RMAP_SCATTER_RETRO:
        y = x / rmap_lobe_number(at, RMAP_SHAPE_SIGMA);
        return rmap_portable_exp(-0.5 * y * y);
    case RMAP_SCATTER_ABG:
        return 1.0 / (rmap_lobe_number(at, RMAP_SHAPE_B) +
                      raised(x, rmap_lobe_number(at, RMAP_SHAPE_G), portable));
    case RMAP_SCATTER_HARVEY:
    case RMAP_SCATTER_K_CORRELATION:
        y = x / width_of(at);
        return raised(1.0 + y * y, 0.5 * power_of(at), portable);
    case RMAP_SCATTER_LAMBERT:
    case RMAP_SCATTER_COSINE:
    case RMAP_SCATTER_GGX:
    case RMAP_SCATTER_BECKMANN:
    case RMAP_SCATTER_UNIFIED:
    case RMAP_SCATTER_TABLE:
    case RMAP_SCATTER_KLEMS:
    case RMAP_SCATTER_CONTAMINATION:
    case RMAP_SCATTER_OREN_NAYAR:
    case RMAP_SCATTER_SLOPE_ERROR:
    case RMAP_SCATTER_COUNT:
        break;
    }
    return 0.0;
}

static bool is_radial(enum rmap_scatter_model model)
{
    return model != RMAP_SCATTER_LAMBERT && model != RMAP_SCATTER_COSINE;
}

/* ---- rough diffuse surfaces: EON over albedo x A_F / pi ---- */

/* (E_F / A_F - 1) / r, E_F the albedo of light that meets one facet: at the horizon, where it is
 * 1, and of light from all around. */
static const double at_horizon = 0.5 - 2.0 / (3.0 * RMAP_PI),
                    all_around = 2.0 / 3.0 - 28.0 / (15.0 * RMAP_PI);

void rmap_rough_diffuse(double r, double albedo, double *amount_ret, double *several_ret)
{
    const double least = 1.0 / (1.0 + at_horizon * r), mean = least * (1.0 + all_around * r);
    *amount_ret = albedo * least / RMAP_PI;
    *several_ret = albedo * mean * r / ((1.0 - albedo * (1.0 - mean)) * (at_horizon - all_around));
}

/* (1 - E_F) / (r A_F): what goes on to other facets. */
static double goes_on(double cosine)
{
    const double sine = rmap_lift(cosine * cosine), angle = rmap_portable_angle(cosine, sine);
    const double far = cosine * (1.0 + sine + sine * sine) / (1.0 + sine);
    return at_horizon - sine * (angle - sine * cosine + 2.0 / 3.0 * (far - 1.0)) / RMAP_PI;
}

/* Towards the light, along the surface: cos1 cos2 less than the cosine of the angle with it. What
 * passes a thin sheet goes on: its relief has the same facets on both sides. */
static double backwards(const struct rmap_scattering *at, struct rmap_vec3 out)
{
    return -rmap_lobe_side(at) * (at->in.x * out.x + at->in.y * out.y);
}

static double rough_shape(const struct rmap_scattering *at, struct rmap_vec3 out)
{
    const double cos_1 = -at->in.z, cos_2 = rmap_lobe_side(at) * out.z, s = backwards(at, out);
    const double t = !(s > 0.0) ? 1.0 : cos_1 > cos_2 ? cos_1 : cos_2;
    return 1.0 + rmap_lobe_number(at, RMAP_SHAPE_R) * s / t +
           rmap_lobe_number(at, RMAP_SHAPE_SEVERAL) * (goes_on(cos_1) * goes_on(cos_2));
}

static double rough_total(const struct rmap_scattering *at)
{
    const double on = goes_on(-at->in.z);
    return RMAP_PI * (1.0 + rmap_lobe_number(at, RMAP_SHAPE_R) * (at_horizon - on) +
                      rmap_lobe_number(at, RMAP_SHAPE_SEVERAL) * (at_horizon - all_around) * on);
}

double rmap_lobe_shape(const struct rmap_scattering *at, struct rmap_vec3 out)
{
    if (!(rmap_lobe_side(at) * out.z > 0.0))
        return 0.0;
    if (at->scatter->model == RMAP_SCATTER_LAMBERT)
        return 1.0;
    if (rmap_scatter_is_table(at->scatter))
        return rmap_table_shape(at, out);
    if (at->scatter->model == RMAP_SCATTER_CONTAMINATION)
        return rmap_dust_shape(at, out);
    if (at->scatter->model == RMAP_SCATTER_OREN_NAYAR)
        return rough_shape(at, out);
    if (at->scatter->model == RMAP_SCATTER_COSINE) {
        double cosine = rmap_dot(rmap_lobe_axis(at), out);
        return cosine > 0.0 ? pow(cosine, rmap_lobe_number(at, RMAP_SHAPE_POWER)) : 0.0;
    }
    struct rmap_vec3 c = rmap_lobe_centre(at);
    double dx = out.x - c.x, dy = out.y - c.y;
    double value = rmap_lobe_radial(at, sqrt(dx * dx + dy * dy), false);
    return rmap_lobe_is_oblique(at) ? value * rmap_lobe_side(at) * out.z : value;
}

/* ---- draws ---- */

/* What draws of x on (0, most) share: a law that x follows, or is kept from. log_y, grown: the
 * logarithm of the range's end, and its power less 1. */
struct radius {
    double most, l, power, log_y, span, grown; /* HARVEY, K_CORRELATION, and ABG beyond its knee */
    double knee, inner, outer;                 /* ABG: integrals on either side */
    double sigma, reach;                       /* GAUSSIAN, RETRO */
};

static bool is_logarithm(const struct radius *its) /* that a power tends to */
{
    return its->span < 1e-7 && its->span > -1e-7;
}

/* x of the density x (1 + (x/l)^2)^(power/2). */
static void set_power_law(double l, double power, struct radius *its)
{
    const double y = its->most / l;
    its->l = l;
    its->power = 0.5 * power + 1.0;
    its->log_y = rmap_portable_log(1.0 + y * y);
    its->span = its->power * its->log_y;
    its->grown = rmap_portable_exp(its->span) - 1.0;
}

static double draw_power_law(const struct radius *its, double u)
{
    const double y = is_logarithm(its)
                         ? rmap_portable_exp(u * its->log_y)
                         : rmap_portable_exp(rmap_portable_log(1.0 + u * its->grown) / its->power);
    return y > 1.0 ? its->l * sqrt(y - 1.0) : 0.0;
}

/* x of the density x / max(B, x^g), which is at most twice that of ABg. */
static void set_abg(const struct rmap_scattering *at, struct radius *its)
{
    const double tail = derived_of(at, RMAP_DERIVED_TAIL);
    its->knee = derived_of(at, RMAP_DERIVED_KNEE);
    its->power = 2.0 - rmap_lobe_number(at, RMAP_SHAPE_G);
    if (!(its->knee < its->most))
        return;
    its->inner = 0.5 * its->knee * its->knee / rmap_lobe_number(at, RMAP_SHAPE_B);
    its->log_y = rmap_portable_log(its->most / its->knee);
    its->span = its->power * its->log_y;
    its->grown = rmap_portable_exp(its->span) - 1.0;
    its->outer = is_logarithm(its) ? tail * its->log_y : tail * its->grown / its->power;
}

static double draw_abg(const struct radius *its, double u)
{
    if (!(its->knee < its->most))
        return its->most * sqrt(u);
    double v = u * (its->inner + its->outer);
    if (v < its->inner)
        return its->knee * sqrt(v / its->inner);
    v = (v - its->inner) / its->outer;
    v = is_logarithm(its) ? v * its->log_y : rmap_portable_log(1.0 + v * its->grown) / its->power;
    return its->knee * rmap_portable_exp(v);
}

static struct radius radius_of(const struct rmap_scattering *at, double most)
{
    struct radius its = {.most = most};
    switch (at->scatter->model) {
    case RMAP_SCATTER_HARVEY:
    case RMAP_SCATTER_K_CORRELATION:
        set_power_law(width_of(at), power_of(at), &its);
        break;
    case RMAP_SCATTER_ABG:
        set_abg(at, &its);
        break;
    default:
        its.sigma = rmap_lobe_number(at, RMAP_SHAPE_SIGMA);
        its.reach = most / its.sigma;
        its.reach = 1.0 - rmap_portable_exp(-0.5 * its.reach * its.reach);
    }
    return its;
}

static double draw_x(const struct rmap_scattering *at, const struct radius *its, double u)
{
    switch (at->scatter->model) {
    case RMAP_SCATTER_HARVEY:
    case RMAP_SCATTER_K_CORRELATION:
        return draw_power_law(its, u);
    case RMAP_SCATTER_ABG:
        return draw_abg(its, u);
    default:
        return its->sigma * sqrt(-2.0 * rmap_portable_log(1.0 - u * its->reach));
    }
}

/* The share of what draw_x draws that is kept. */
static double kept(const struct rmap_scattering *at, double x)
{
    if (at->scatter->model != RMAP_SCATTER_ABG)
        return 1.0;
    double b = rmap_lobe_number(at, RMAP_SHAPE_B);
    double power = rmap_portable_power(x, rmap_lobe_number(at, RMAP_SHAPE_G));
    return (power > b ? power : b) / (b + power);
}

static void draw_numbers(const struct rmap_draw *draw, int k, double u[4])
{
    rmap_rng(draw->seed, draw->ray, draw->step, (enum rmap_rng_slot)(RMAP_RNG_LOBE + k), u);
}

static struct rmap_vec3 draw_radial(const struct rmap_scattering *at, const struct rmap_draw *draw)
{
    struct rmap_vec3 c = rmap_lobe_centre(at);
    double u[4], cosine, sine;
    const struct radius radius = radius_of(at, 1.0 + sqrt(c.x * c.x + c.y * c.y));
    for (int k = 0; k < RMAP_TRIES_MAX; k++) {
        draw_numbers(draw, k, u);
        double x = draw_x(at, &radius, u[0]);
        rmap_azimuth(u[1], &cosine, &sine);
        double bx = c.x + x * cosine, by = c.y + x * sine, square = bx * bx + by * by;
        if (!(square < 1.0))
            continue;
        double z = sqrt(1.0 - square);
        if ((rmap_lobe_is_oblique(at) && !(u[3] < z)) || !(u[2] < kept(at, x)))
            continue;
        return rmap_vec3(bx, by, rmap_lobe_side(at) * z);
    }
    return rmap_lobe_axis(at);
}

void rmap_scatter_derive(struct rmap_scatter *scatter, int n_channel)
{
    double(*derived)[RMAP_CHANNEL_MAX] = scatter->derived;
    for (int i = 0; i < n_channel; i++)
        if (scatter->model == RMAP_SCATTER_ABG) {
            const double b = scatter->shape[RMAP_SHAPE_B][i], g = scatter->shape[RMAP_SHAPE_G][i];
            derived[RMAP_DERIVED_KNEE][i] = rmap_portable_power(b, 1.0 / g);
            derived[RMAP_DERIVED_TAIL][i] =
                rmap_portable_power(derived[RMAP_DERIVED_KNEE][i], 2.0 - g);
        } else if (scatter->model == RMAP_SCATTER_COSINE) {
            const double power = scatter->shape[RMAP_SHAPE_POWER][i];
            const double far = rmap_portable_exp(-30.0 / (power + 1.0));
            derived[RMAP_DERIVED_FARTHEST][i] = rmap_lift(far * far);
        }
}

static struct rmap_vec3 draw_cosine(const struct rmap_scattering *at, const struct rmap_draw *draw)
{
    struct rmap_vec3 axis = rmap_lobe_axis(at), x, y;
    double power = rmap_lobe_number(at, RMAP_SHAPE_POWER), u[4], cosine, sine;
    double most = fabs(axis.z) + derived_of(at, RMAP_DERIVED_FARTHEST);
    rmap_basis(axis, &x, &y);
    for (int k = 0; k < RMAP_TRIES_MAX; k++) {
        draw_numbers(draw, k, u);
        double along = rmap_portable_power(u[0], 1.0 / (power + 1.0)),
               away = rmap_lift(along * along);
        rmap_azimuth(u[1], &cosine, &sine);
        struct rmap_vec3 out =
            rmap_axpy(along, axis, rmap_axpy(away * cosine, x, rmap_scale(y, away * sine)));
        if (u[2] * (most < 1.0 ? most : 1.0) < rmap_lobe_side(at) * out.z)
            return out;
    }
    return axis;
}

/* Lambert's law about z, which exceeds all but what is sent back, or about the horizontal way back:
 * s / t is at most s / cos2. */
static struct rmap_vec3 draw_rough(const struct rmap_scattering *at, const struct rmap_draw *draw)
{
    const double side = rmap_lobe_side(at), cos_1 = -at->in.z,
                 r = rmap_lobe_number(at, RMAP_SHAPE_R);
    const double several = rmap_lobe_number(at, RMAP_SHAPE_SEVERAL) * goes_on(cos_1);
    const double even = 1.0 + several * at_horizon,
                 sine_1 = sqrt(at->in.x * at->in.x + at->in.y * at->in.y);
    const struct rmap_vec3 back =
        sine_1 > 0.0 ? rmap_vec3(-side * at->in.x / sine_1, -side * at->in.y / sine_1, 0.0)
                     : rmap_vec3(1.0, 0.0, 0.0);
    double u[4], cosine, sine;
    for (int k = 0; k < RMAP_TRIES_MAX; k++) {
        draw_numbers(draw, k, u);
        rmap_azimuth(u[1], &cosine, &sine);
        const double away = sqrt(u[0]), along = sqrt(1.0 - u[0]);
        if (u[2] * (even + 0.5 * r * sine_1) < even) {
            const struct rmap_vec3 out = {away * cosine, away * sine, side * along};
            const double s = backwards(at, out), once = 1.0 + (s < 0.0 ? r * s : 0.0);
            if (u[3] * even < once || u[3] * even < once + several * goes_on(along))
                return out;
        } else if (u[3] * cos_1 < away * fabs(sine)) {
            return rmap_vec3(along * back.x - away * cosine * back.y,
                             along * back.y + away * cosine * back.x, side * away * fabs(sine));
        }
    }
    return rmap_lobe_axis(at);
}

struct rmap_vec3 rmap_lobe_draw(const struct rmap_scattering *at, const struct rmap_draw *draw)
{
    double u[4], cosine, sine;
    if (rmap_scatter_is_table(at->scatter))
        return rmap_table_draw(at, draw);
    if (at->scatter->model == RMAP_SCATTER_CONTAMINATION)
        return rmap_dust_draw(at, draw);
    if (at->scatter->model == RMAP_SCATTER_COSINE)
        return draw_cosine(at, draw);
    if (at->scatter->model == RMAP_SCATTER_OREN_NAYAR)
        return draw_rough(at, draw);
    if (is_radial(at->scatter->model))
        return draw_radial(at, draw);
    draw_numbers(draw, 0, u);
    rmap_azimuth(u[1], &cosine, &sine);
    return rmap_vec3(sqrt(u[0]) * cosine, sqrt(u[0]) * sine, rmap_lobe_side(at) * sqrt(1.0 - u[0]));
}

double rmap_lobe_total(const struct rmap_scattering *at)
{
    if (at->scatter->model == RMAP_SCATTER_UNIFIED) {
        double fit;
        rmap_facet_fit(at, 1, &at->in, &fit);
        return fit;
    }
    if (rmap_scatter_is_table(at->scatter))
        return rmap_table_total(at);
    if (at->scatter->model == RMAP_SCATTER_CONTAMINATION)
        return rmap_dust_total(at);
    if (at->scatter->model == RMAP_SCATTER_LAMBERT)
        return RMAP_PI;
    if (at->scatter->model == RMAP_SCATTER_OREN_NAYAR)
        return rough_total(at);
    return at->scatter->model == RMAP_SCATTER_COSINE ? rmap_cosine_total(at)
                                                     : rmap_radial_total(at);
}

double rmap_rough_share(double roughness, bool passes, double n1, double cos_1, double n2,
                        double cos_2)
{
    double phase = passes ? n1 * cos_1 - n2 * cos_2 : 2.0 * n1 * cos_1;
    double wave = 2.0 * RMAP_PI * roughness * phase;
    return rmap_portable_one_minus_exp(wave * wave);
}
