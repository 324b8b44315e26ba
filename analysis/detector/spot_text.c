/* SPDX-License-Identifier: MIT
 *
 * A spot for people, as JSON and as CSV.
 */
#include <math.h>

#include "analysis/detector/spot.h"
#include "io/export/json_number.h"

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
    for (size_t d = 0; d < 2 && spot->n_frequency; d++) {
        const struct rmap_estimate half = spot->half[d];
        const char *name = d == 0 ? "MTF 50 % tan." : "MTF 50 % sag.";
        char unit[64];
        (void)snprintf(unit, sizeof unit, "cycles/%s", spot->unit);
        print_line(name, half, unit, out);
        if (!isfinite(half.value) && isfinite(spot->rms_radius.value))
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
