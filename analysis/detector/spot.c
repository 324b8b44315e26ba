/* SPDX-License-Identifier: MIT
 *
 * A spot: where the light on a plane has its centre, how large it is, which part of it lies within
 * a radius, and which contrast it leaves to lines (MTF), each with the standard error that the
 * number of rays gives it.
 */
#include <math.h>

#include "analysis/detector/spot.h"
#include "analysis/table/flux_error.h"
#include "base/alloc.h"
#include "io/export/json_number.h"

/* Sums over sources, in flux. */
struct totals {
    const struct rmap_spot_sums *sums;
    const double *flux, *emitted; /* per source: of a unit of weight; rays */
    double v[RMAP_SPOT_VECTOR];
};

static double moment(const struct totals *totals, size_t source, size_t k)
{
    return rmap_exact_sum_value(
        &totals->sums->sum[source * (RMAP_SPOT_VECTOR + RMAP_SPOT_GRAM) + k]);
}

static double product(const struct totals *totals, size_t source, size_t j, size_t k)
{
    const size_t low = j < k ? j : k, high = j < k ? k : j;
    const size_t row = low * RMAP_SPOT_VECTOR - low * (low - 1) / 2;
    return moment(totals, source, RMAP_SPOT_VECTOR + row + high - low);
}

/* One source's part of the variance of a sum whose terms u have these sums. */
static double part(const struct totals *totals, size_t source, double u, double uu)
{
    if (!(moment(totals, source, 0) > 0.0)) /* no light of it here */
        return 0.0;
    return rmap_flux_variance(totals->flux[source], totals->emitted[source], u, uu);
}

/* Standard error of an estimate to which a ray with vector v contributes c . v. */
static double error_along(const struct totals *totals, const double c[RMAP_SPOT_VECTOR])
{
    double variance = 0.0;
    for (size_t s = 0; s < totals->sums->n_source; s++) {
        double u = 0.0, uu = 0.0;
        for (size_t j = 0; j < RMAP_SPOT_VECTOR; j++) {
            u += c[j] * moment(totals, s, j);
            for (size_t k = 0; k < RMAP_SPOT_VECTOR; k++)
                uu += c[j] * c[k] * product(totals, s, j, k);
        }
        variance += part(totals, s, u, uu);
    }
    return rmap_flux_error(variance);
}

static void fill_moments(const struct totals *totals, struct rmap_spot *spot)
{
    const double *v = totals->v, T = v[0];
    const double c[2] = {v[1] / T, v[2] / T};
    const double m[2] = {v[3] / T - c[0] * c[0], v[4] / T - c[1] * c[1]};
    double both[RMAP_SPOT_VECTOR] = {0.0};
    spot->flux = (struct rmap_estimate){T, error_along(totals, (const double[5]){1.0})};
    for (size_t k = 0; k < 2; k++) {
        double of_c[RMAP_SPOT_VECTOR] = {-c[k] / T}, of_m[RMAP_SPOT_VECTOR] = {0.0};
        of_c[1 + k] = 1.0 / T;
        of_m[0] = (c[k] * c[k] - m[k]) / T; /* ((x - c)^2 - m) / T */
        of_m[1 + k] = -2.0 * c[k] / T;
        of_m[3 + k] = 1.0 / T;
        for (int i = 0; i < RMAP_SPOT_VECTOR; i++)
            both[i] += of_m[i];
        const double rms = sqrt(fmax(m[k], 0.0));
        spot->centroid[k] =
            (struct rmap_estimate){totals->sums->ask.centre[k] + c[k], error_along(totals, of_c)};
        spot->rms[k] = (struct rmap_estimate){rms, error_along(totals, of_m) / (2.0 * rms)};
    }
    const double radius = sqrt(fmax(m[0] + m[1], 0.0));
    spot->rms_radius = (struct rmap_estimate){radius, error_along(totals, both) / (2.0 * radius)};
}

/* ---- encircled energy ---- */

/* Per source sums within a ring: of w, of w^2 per ray, of w times the ray's all. */
struct rings {
    const struct totals *totals;
    double (*within)[3]; /* [n_source] */
    size_t ring;         /* behind the last one added */
    double inside;       /* flux */
};

static void rings_restart(struct rings *rings)
{
    for (size_t s = 0; s < rings->totals->sums->n_source; s++)
        rings->within[s][0] = rings->within[s][1] = rings->within[s][2] = 0.0;
    rings->ring = 0;
    rings->inside = 0.0;
}

/* Adds the next ring; its flux. */
static double rings_add(struct rings *rings)
{
    const struct rmap_spot_sums *sums = rings->totals->sums;
    double flux = 0.0;
    for (size_t s = 0; s < sums->n_source; s++) {
        const double *ring = sums->ring + 3 * s * RMAP_SPOT_RINGS + rings->ring;
        for (size_t k = 0; k < 3; k++)
            rings->within[s][k] += ring[k * RMAP_SPOT_RINGS];
        flux += rings->totals->flux[s] * ring[0];
    }
    rings->ring++;
    rings->inside += flux;
    return flux;
}

/* Standard error of the part that lies within the rings so far, where it is `fraction`. */
static double fraction_error(const struct rings *rings, double fraction)
{
    const struct totals *totals = rings->totals;
    const double T = totals->v[0];
    double variance = 0.0;
    for (size_t s = 0; s < totals->sums->n_source; s++) {
        const double *in = rings->within[s];
        const double u = in[0] - fraction * moment(totals, s, 0);
        const double uu =
            in[1] - 2.0 * fraction * in[2] + fraction * fraction * product(totals, s, 0, 0);
        variance += part(totals, s, u / T, uu / (T * T));
    }
    return rmap_flux_error(variance);
}

/* Radius within which `fraction` of the light lies; its error as a fraction's if wanted. */
static double radius_of(struct rings *rings, double fraction, double *error_ret)
{
    const struct rmap_spot_sums *sums = rings->totals->sums;
    const double wanted = fraction * rings->totals->v[0];
    rings_restart(rings);
    while (rings->ring < RMAP_SPOT_RINGS) {
        const double flux = rings_add(rings);
        if (rings->inside < wanted || flux == 0.0)
            continue;
        const double end = rmap_spot_ring_end(sums, rings->ring - 1);
        const double begin = rings->ring > 1 ? rmap_spot_ring_end(sums, rings->ring - 2) : 0.0;
        if (error_ret)
            *error_ret = fraction_error(rings, fraction);
        return end - (end - begin) * (rings->inside - wanted) / flux;
    }
    return (double)NAN;
}

static struct rmap_estimate radius_estimate(struct rings *rings, double fraction)
{
    double error = 0.0;
    const double radius = radius_of(rings, fraction, &error);
    double step = fmin(fmax(2.0 * error, 0.02), 0.5 * fmin(fraction, 1.0 - fraction));
    if (isnan(error))
        return (struct rmap_estimate){radius, (double)NAN};
    const double slope =
        (radius_of(rings, fraction + step, NULL) - radius_of(rings, fraction - step, NULL)) /
        (2.0 * step);
    return (struct rmap_estimate){radius, error * slope};
}

/* Radii from 0 to a little more than where 95 % lie. */
static void fill_curve(struct rings *rings, struct rmap_spot *spot)
{
    const double longest = 1.25 * radius_of(rings, 0.95, NULL), T = rings->totals->v[0];
    rings_restart(rings);
    for (int i = 0; i < RMAP_SPOT_CURVE; i++) {
        const double radius = longest * i / (RMAP_SPOT_CURVE - 1);
        while (rings->ring < RMAP_SPOT_RINGS &&
               rmap_spot_ring_end(rings->totals->sums, rings->ring) <= radius)
            (void)rings_add(rings);
        const double fraction = rings->inside / T;
        spot->curve_radius[i] = radius;
        spot->curve[i] = (struct rmap_estimate){fraction, fraction_error(rings, fraction)};
    }
}

static enum rmap_status fill_rings(const struct totals *totals, struct rmap_spot *spot,
                                   struct rmap_error *err)
{
    struct rings rings = {.totals = totals};
    rings.within = rmap_alloc(totals->sums->n_source, sizeof *rings.within);
    if (!rings.within)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a spot");
    for (int i = 0; i < RMAP_SPOT_FRACTIONS; i++)
        spot->radius[i] = radius_estimate(&rings, spot->fraction[i]);
    fill_curve(&rings, spot);
    rmap_free(rings.within);
    return RMAP_OK;
}

/* ---- MTF ---- */

static struct rmap_estimate modulation(const struct totals *totals, size_t k)
{
    const struct rmap_spot_sums *sums = totals->sums;
    const size_t stride = 2 * sums->ask.n_frequency * RMAP_SPOT_WAVES;
    const int64_t *wave = sums->wave + k * RMAP_SPOT_WAVES;
    const double T = totals->v[0];
    double C = 0.0, S = 0.0, variance = 0.0;
    for (size_t s = 0; s < sums->n_source; s++) {
        C += totals->flux[s] * ((double)wave[s * stride] / RMAP_SPOT_FIXED);
        S += totals->flux[s] * ((double)wave[s * stride + 1] / RMAP_SPOT_FIXED);
    }
    const double H = hypot(C, S), M = H / T;
    const double c = H > 0.0 ? C / H : 1.0, si = H > 0.0 ? S / H : 0.0;
    for (size_t s = 0; s < sums->n_source; s++) {
        double w[RMAP_SPOT_WAVES];
        for (size_t i = 0; i < RMAP_SPOT_WAVES; i++)
            w[i] = (double)wave[s * stride + i] / RMAP_SPOT_FIXED;
        /* A ray adds (c cos + si sin - M q) / T. */
        const double u = c * w[0] + si * w[1] - M * moment(totals, s, 0);
        const double uu = c * c * w[2] + 2.0 * c * si * w[3] + si * si * w[4] -
                          2.0 * M * (c * w[5] + si * w[6]) + M * M * product(totals, s, 0, 0);
        variance += part(totals, s, u / T, uu / (T * T));
    }
    return (struct rmap_estimate){M, rmap_flux_error(variance)};
}

/* ---- all of it ---- */

static void fill_nothing(struct rmap_spot *spot)
{
    const struct rmap_estimate none = {(double)NAN, (double)NAN};
    spot->rms_radius = none;
    for (int k = 0; k < 2; k++)
        spot->centroid[k] = spot->rms[k] = none;
    for (int k = 0; k < RMAP_SPOT_FRACTIONS; k++)
        spot->radius[k] = none;
    for (int k = 0; k < RMAP_SPOT_CURVE; k++) {
        spot->curve[k] = none;
        spot->curve_radius[k] = (double)NAN;
    }
    for (size_t k = 0; k < 2 * spot->n_frequency; k++)
        spot->mtf[k] = none;
}

/* The lowest frequency at which the contrast is down to one half, between two of the curve; its
 * error is that of the contrast there over the slope. NaN: none. */
static struct rmap_estimate half_contrast(const struct rmap_spot *spot, size_t direction)
{
    const struct rmap_estimate *mtf = spot->mtf + direction * spot->n_frequency;
    for (size_t k = 1; k < spot->n_frequency; k++) {
        const double fall = mtf[k - 1].value - mtf[k].value;
        const double back = (0.5 - mtf[k].value) / fall;
        if (mtf[k].value < 0.5 && mtf[k - 1].value >= 0.5)
            return (struct rmap_estimate){
                spot->frequency_step * ((double)k - back),
                spot->frequency_step / fall *
                    (back * mtf[k - 1].standard_error + (1.0 - back) * mtf[k].standard_error)};
    }
    return (struct rmap_estimate){(double)NAN, (double)NAN};
}

enum rmap_status rmap_spot_create(const struct rmap_spot_sums *sums, struct rmap_spot **spot_ret,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_spot_ask *ask = &sums->ask;
    struct totals totals = {.sums = sums,
                            .flux = rmap_map_flux_per_weight(ask->map),
                            .emitted = rmap_map_emitted(ask->map)};
    struct rmap_spot *spot = rmap_alloc(1, sizeof *spot);
    if (spot)
        spot->mtf = rmap_alloc(2 * ask->n_frequency + 1, sizeof *spot->mtf);
    if (!spot || !spot->mtf) {
        rmap_spot_destroy(spot);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a spot");
    }
    spot->unit = rmap_map_scene(ask->map)->unit;
    spot->fraction[0] = 0.5;
    spot->fraction[1] = 0.8;
    spot->fraction[2] = 0.9;
    spot->tangential_deg = ask->tangential_rad * 180.0 / RMAP_PI;
    spot->n_frequency = ask->n_frequency;
    spot->frequency_step = ask->frequency_step;
    for (size_t s = 0; s < sums->n_source; s++)
        for (size_t k = 0; k < RMAP_SPOT_VECTOR; k++)
            totals.v[k] += totals.flux[s] * moment(&totals, s, k);
    if (totals.v[0] > 0.0) {
        fill_moments(&totals, spot);
        if (!ask->moments_alone)
            RMAP_TRY(fill_rings(&totals, spot, err));
        for (size_t k = 0; k < 2 * ask->n_frequency; k++)
            spot->mtf[k] = modulation(&totals, k);
        for (size_t d = 0; d < 2; d++)
            spot->half[d] = half_contrast(spot, d);
    } else {
        fill_nothing(spot);
    }
    *spot_ret = spot;
    spot = NULL;
out:
    rmap_spot_destroy(spot);
    return st;
}

void rmap_spot_destroy(struct rmap_spot *spot)
{
    if (!spot)
        return;
    rmap_free(spot->mtf);
    rmap_free(spot);
}

/* A spot for people, as JSON and as CSV. */

static void print_line(const char *name, struct rmap_estimate estimate, const char *unit, FILE *out)
{
    if (!isfinite(estimate.value))
        return;
    fprintf(out, "%-14s %.6g", name, estimate.value);
    if (isfinite(estimate.standard_error))
        fprintf(out, " +- %.2g", estimate.standard_error);
    fprintf(out, " %s\n", unit);
}

void rmap_spot_print(const struct rmap_spot *spot, FILE *out)
{
    print_line("centroid x", spot->centroid[0], spot->unit, out);
    print_line("centroid y", spot->centroid[1], spot->unit, out);
    print_line("RMS x", spot->rms[0], spot->unit, out);
    print_line("RMS y", spot->rms[1], spot->unit, out);
    print_line("RMS radius", spot->rms_radius, spot->unit, out);
    for (int i = 0; i < RMAP_SPOT_FRACTIONS; i++) {
        char name[32];
        (void)snprintf(name, sizeof name, "%.0f %% within", 100.0 * spot->fraction[i]);
        print_line(name, spot->radius[i], spot->unit, out);
    }
    for (size_t d = 0; d < 2 && spot->n_frequency && isfinite(spot->rms_radius.value); d++) {
        const struct rmap_estimate half = spot->half[d];
        const char *name = d == 0 ? "MTF 50 % tan." : "MTF 50 % sag.";
        char unit[64];
        (void)snprintf(unit, sizeof unit, "cycles/%s", spot->unit);
        print_line(name, half, unit, out);
        if (!isfinite(half.value))
            fprintf(out, "%-14s beyond %.6g %s: --frequency F goes further\n", name,
                    spot->frequency_step * (double)(spot->n_frequency - 1), unit);
    }
}

static json_t *estimate_json(struct rmap_estimate estimate)
{
    return json_pack("{s:o, s:o}", "value", rmap_json_number(estimate.value), "standard_error",
                     rmap_json_number(estimate.standard_error));
}

/* Two lists under the names given. */
static void put_lists(json_t *object, const char *values, const char *errors,
                      const struct rmap_estimate *estimate, size_t n)
{
    json_t *value = json_array(), *error = json_array();
    for (size_t i = 0; i < n; i++) {
        (void)json_array_append_new(value, rmap_json_number(estimate[i].value));
        (void)json_array_append_new(error, rmap_json_number(estimate[i].standard_error));
    }
    (void)json_object_set_new(object, values, value);
    (void)json_object_set_new(object, errors, error);
}

static json_t *mtf_json(const struct rmap_spot *spot)
{
    json_t *frequency = json_array(), *mtf = json_object();
    for (size_t k = 0; k < spot->n_frequency; k++)
        (void)json_array_append_new(frequency, json_real(spot->frequency_step * (double)k));
    (void)json_object_set_new(mtf, "unit", json_sprintf("cycles/%s", spot->unit));
    (void)json_object_set_new(mtf, "tangential_direction", json_real(spot->tangential_deg));
    (void)json_object_set_new(mtf, "frequency", frequency);
    put_lists(mtf, "tangential", "tangential_standard_error", spot->mtf, spot->n_frequency);
    put_lists(mtf, "sagittal", "sagittal_standard_error", spot->mtf + spot->n_frequency,
              spot->n_frequency);
    (void)json_object_set_new(mtf, "half",
                              json_pack("{s:o, s:o}", "tangential", estimate_json(spot->half[0]),
                                        "sagittal", estimate_json(spot->half[1])));
    return mtf;
}

void rmap_spot_json(const struct rmap_spot *spot, json_t *document)
{
    json_t *within = json_array(), *radius = json_array(), *curve = json_object();
    for (int i = 0; i < RMAP_SPOT_FRACTIONS; i++)
        (void)json_array_append_new(
            within, json_pack("{s:f, s:o, s:o}", "fraction", spot->fraction[i], "radius",
                              rmap_json_number(spot->radius[i].value), "standard_error",
                              rmap_json_number(spot->radius[i].standard_error)));
    for (int i = 0; i < RMAP_SPOT_CURVE; i++)
        (void)json_array_append_new(radius, rmap_json_number(spot->curve_radius[i]));
    (void)json_object_set_new(curve, "radius", radius);
    put_lists(curve, "fraction", "standard_error", spot->curve, RMAP_SPOT_CURVE);
    (void)json_object_set_new(
        document, "spot",
        json_pack("{s:{s:o, s:o}, s:{s:o, s:o, s:o}, s:o, s:o, s:s}", "centroid", "x",
                  estimate_json(spot->centroid[0]), "y", estimate_json(spot->centroid[1]), "rms",
                  "x", estimate_json(spot->rms[0]), "y", estimate_json(spot->rms[1]), "radius",
                  estimate_json(spot->rms_radius), "encircled", within, "curve", curve, "unit",
                  spot->unit));
    if (spot->n_frequency)
        (void)json_object_set_new(document, "mtf", mtf_json(spot));
}

static void put_row(const char *curve, double at, struct rmap_estimate estimate, FILE *out)
{
    if (isfinite(estimate.value) && isfinite(estimate.standard_error))
        fprintf(out, "%s,%.17g,%.17g,%.17g\n", curve, at, estimate.value, estimate.standard_error);
    else if (isfinite(estimate.value))
        fprintf(out, "%s,%.17g,%.17g,\n", curve, at, estimate.value);
}

void rmap_spot_csv(const struct rmap_spot *spot, const char *detector, const char *criterion,
                   FILE *out)
{
    fprintf(out, "# detector: %s\n# criterion: %s\n", detector, criterion ? criterion : "all");
    rmap_which_csv(spot->which, out);
    fprintf(out, "# encircled: at a radius in %s; tangential, sagittal: MTF at cycles/%s\n",
            spot->unit, spot->unit);
    fprintf(out, "curve,at,value,standard_error\n");
    for (int i = 0; i < RMAP_SPOT_CURVE; i++)
        put_row("encircled", spot->curve_radius[i], spot->curve[i], out);
    for (size_t k = 0; k < 2 * spot->n_frequency; k++)
        put_row(k < spot->n_frequency ? "tangential" : "sagittal",
                spot->frequency_step * (double)(k % spot->n_frequency), spot->mtf[k], out);
}
