/* SPDX-License-Identifier: MIT
 *
 * What light a detector caught, as colour.
 */
#include "analysis/detector/detector_colour.h"

#include <math.h>
#include <string.h>

#include "analysis/table/colour_map.h"
#include "base/alloc.h"
#include "io/export/json_number.h"

const char *const rmap_colour_number[RMAP_COLOUR_NUMBERS] = {"X",
                                                             "Y",
                                                             "Z",
                                                             "X_error",
                                                             "Y_error",
                                                             "Z_error",
                                                             "chromaticity_x",
                                                             "chromaticity_y",
                                                             "u_prime",
                                                             "v_prime",
                                                             "CCT",
                                                             "Duv",
                                                             "Ra"};

double rmap_colour_number_of(const struct rmap_colour_reading *reading, int number)
{
    const struct rmap_chromaticity *of = &reading->value;
    const double rest[] = {of->x, of->y, of->u, of->v, of->kelvin, of->duv, reading->general};
    return number < 3   ? reading->xyz[number]
           : number < 6 ? reading->xyz_error[number - 3]
                        : rest[number - 6];
}

/* How X, Y and Z vary together, from the errors of their sums in pairs. */
static void find_covariance(const double error[RMAP_XYZ_SUMS], double of[3][3])
{
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3;
        of[i][i] = error[i] * error[i];
        of[i][j] = of[j][i] =
            0.5 * (error[3 + i] * error[3 + i] - error[i] * error[i] - error[j] * error[j]);
    }
}

/* By the delta method, with slopes taken over a ten-thousandth of the light. */
static void find_errors(const struct rmap_planck_locus *locus, double covariance[3][3],
                        struct rmap_colour_reading *reading)
{
    const double step = 1e-4 * (reading->xyz[0] + reading->xyz[1] + reading->xyz[2]);
    double variance[6] = {0.0}, slope[6][3];
    for (int i = 0; i < 3; i++) {
        struct rmap_chromaticity side[2];
        for (int k = 0; k < 2; k++) {
            double xyz[3] = {reading->xyz[0], reading->xyz[1], reading->xyz[2]};
            xyz[i] += k ? step : -step;
            rmap_chromaticity_of(locus, xyz, &side[k]);
        }
        const double change[6] = {side[1].x - side[0].x,           side[1].y - side[0].y,
                                  side[1].u - side[0].u,           side[1].v - side[0].v,
                                  side[1].kelvin - side[0].kelvin, side[1].duv - side[0].duv};
        for (int n = 0; n < 6; n++)
            slope[n][i] = change[n] / (2.0 * step);
    }
    for (int n = 0; n < 6; n++)
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++)
                variance[n] += slope[n][i] * covariance[i][j] * slope[n][j];
    for (int n = 0; n < 6; n++)
        variance[n] = isnan(variance[n]) ? (double)NAN : sqrt(fmax(variance[n], 0.0));
    reading->error = (struct rmap_chromaticity){variance[0], variance[1], variance[2],
                                                variance[3], variance[4], variance[5]};
}

/* Of a cell (n_cell: of all) of that extent. */
static void read_cell(const struct rmap_detector_sums *sums, const struct rmap_planck_locus *locus,
                      size_t cell, double extent, struct rmap_colour_reading *reading)
{
    double sum[RMAP_XYZ_SUMS], error[RMAP_XYZ_SUMS], covariance[3][3];
    for (size_t k = 0; k < RMAP_XYZ_SUMS; k++) {
        rmap_detector_sums_channel(sums, 0, sums->n_source, sums->n_spectral + sums->n_seen + k,
                                   cell, &sum[k], &error[k]);
        sum[k] /= extent;
        error[k] /= extent;
    }
    const double luminous = sum[1] > 0.0 ? sum[6] / sum[1] : 1.0; /* Y as light is counted */
    for (int k = 0; k < 6; k++) {
        sum[k] *= luminous;
        error[k] *= luminous;
    }
    for (int k = 0; k < 3; k++) {
        reading->xyz[k] = sum[k];
        reading->xyz_error[k] = error[k];
    }
    reading->general = (double)NAN;
    rmap_chromaticity_of(locus, reading->xyz, &reading->value);
    find_covariance(error, covariance);
    find_errors(locus, covariance, reading);
}

static const double HOTTEST = 25000.0; /* phase of daylight */

/* Of the light of a cell whose colour is read. */
static void render(const struct rmap_detector_sums *sums, size_t cell,
                   struct rmap_colour_reading *reading, struct rmap_cri *cri)
{
    const struct rmap_scene *scene = rmap_map_scene(sums->ask.map);
    double watt[RMAP_CHANNEL_MAX], error;
    if (!(reading->value.kelvin <= HOTTEST))
        return;
    for (size_t c = 0; c < sums->n_spectral; c++) {
        const double seen = rmap_luminous_efficiency(scene->channels.wavelength_nm[c]);
        rmap_detector_sums_channel(sums, 0, sums->n_source, c, cell, &watt[c], &error);
        if (scene->flux_unit == RMAP_FLUX_LM)
            watt[c] = seen > 0.0 ? watt[c] / seen : 0.0;
        else if (scene->flux_unit == RMAP_FLUX_PHOTONS || scene->flux_unit == RMAP_FLUX_PHOTON_RATE)
            watt[c] /= scene->channels.wavelength_nm[c];
    }
    rmap_cri_of(&scene->channels, watt, reading->value.kelvin, cri);
    reading->general = cri->general;
}

/* What cannot be told of the whole, and why. */
static void find_reasons(const struct rmap_detector_sums *sums, struct rmap_detector_colour *colour)
{
    const struct rmap_channels *channels = &rmap_map_scene(sums->ask.map)->channels;
    if (!(colour->all.xyz[1] > 0.0))
        colour->no_cct = "no light that is seen";
    else if (channels->mode == RMAP_COLOUR_SPECTRAL && channels->n == 1)
        colour->no_cct = "one wavelength has none";
    else if (isnan(colour->all.value.kelvin))
        colour->no_cct =
            "farther than 0.05 from Planck's locus in u, v, or not in 1000 to 100000 K";
    if (colour->no_cct)
        colour->all.value.kelvin = colour->all.value.duv = (double)NAN;
    colour->no_cri = rmap_cri_refused(channels);
    if (!colour->no_cri && colour->no_cct)
        colour->no_cri = "it is against light of the same colour temperature, and there is none";
    else if (!colour->no_cri && colour->all.value.kelvin > HOTTEST)
        colour->no_cri = "beyond 25000 K there is no light to hold it against";
}

/* Of amounts of light: lx s, cd s/m2. */
static void name_unit(const struct rmap_detector_sums *sums, char unit[RMAP_COLOUR_UNIT])
{
    const enum rmap_flux_unit flux = rmap_map_scene(sums->ask.map)->flux_unit;
    const char *lumens = rmap_image_unit_usual(sums->ask.bins.quantity, RMAP_FLUX_LM)->name;
    const int upper = (int)strcspn(lumens, "/");
    const bool amount = flux == RMAP_FLUX_PHOTONS || flux == RMAP_FLUX_J;
    (void)snprintf(unit, RMAP_COLOUR_UNIT, "%.*s%s%s", upper, lumens, amount ? " s" : "",
                   lumens + upper);
}

enum rmap_status rmap_detector_colour_create(const struct rmap_detector_sums *sums,
                                             struct rmap_detector_colour **colour_ret,
                                             struct rmap_error *err)
{
    const struct rmap_detector_bins *bins = &sums->ask.bins;
    struct rmap_planck_locus locus;
    struct rmap_detector_colour *colour = rmap_alloc(1, sizeof *colour);
    if (colour)
        colour->cell = rmap_alloc(sums->n_cell, sizeof *colour->cell);
    if (!colour || !colour->cell) {
        rmap_detector_colour_destroy(colour);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the colour of %zu cells",
                              sums->n_cell);
    }
    rmap_planck_locus_fill(&locus);
    name_unit(sums, colour->unit);
    colour->n_cell = sums->n_cell;
    read_cell(sums, &locus, sums->n_cell, rmap_detector_bins_whole(bins), &colour->all);
    find_reasons(sums, colour);
    if (!colour->no_cri)
        render(sums, sums->n_cell, &colour->all, &colour->cri);
    colour->cri_of_cells = !colour->no_cri && sums->ask.channels;
    for (size_t c = 0; c < sums->n_cell; c++) {
        struct rmap_cri cri;
        read_cell(sums, &locus, c, rmap_detector_bins_extent(bins, c), &colour->cell[c]);
        if (colour->cri_of_cells)
            render(sums, c, &colour->cell[c], &cri);
    }
    *colour_ret = colour;
    return RMAP_OK;
}

void rmap_detector_colour_destroy(struct rmap_detector_colour *colour)
{
    if (colour)
        rmap_free(colour->cell);
    rmap_free(colour);
}

static void put(const char *name, double value, double error, FILE *out)
{
    fprintf(out, "%s%.6g", name, value);
    if (isfinite(error))
        fprintf(out, " +- %.2g", error);
}

void rmap_detector_colour_print(const struct rmap_detector_colour *colour, FILE *out)
{
    const struct rmap_colour_reading *all = &colour->all;
    static const char *const name[] = {"X ", ", Y ", ", Z "};
    fprintf(out, "%-14s ", "colour");
    for (int k = 0; k < 3; k++)
        put(name[k], all->xyz[k], all->xyz_error[k], out);
    fprintf(out, " %s\n", colour->unit);
    if (isfinite(all->value.x)) {
        fprintf(out, "%-14s ", "chromaticity");
        put("x ", all->value.x, all->error.x, out);
        put(", y ", all->value.y, all->error.y, out);
        put("; u' ", all->value.u, all->error.u, out);
        put(", v' ", all->value.v, all->error.v, out);
        fputc('\n', out);
    }
    fprintf(out, "%-14s ", "CCT");
    if (colour->no_cct) {
        fprintf(out, "none: %s\n", colour->no_cct);
    } else {
        put("", all->value.kelvin, all->error.kelvin, out);
        put(" K, Duv ", all->value.duv, all->error.duv, out);
        fputc('\n', out);
    }
    fprintf(out, "%-14s ", "CRI");
    if (colour->no_cri) {
        fprintf(out, "none: %s\n", colour->no_cri);
        return;
    }
    fprintf(out, "Ra %.1f; R1 to R%d:", all->general, RMAP_CRI_SAMPLES);
    for (int k = 0; k < RMAP_CRI_SAMPLES; k++)
        fprintf(out, " %.0f", colour->cri.special[k]);
    fputc('\n', out);
}

static json_t *numbers(const double *value, int n)
{
    json_t *list = json_array();
    for (int k = 0; k < n; k++)
        (void)json_array_append_new(list, rmap_json_number(value[k]));
    return list;
}

/* Bytes of the light's own colour, as bright as can be shown. */
static json_t *srgb_json(const double xyz[3])
{
    double linear[3];
    uint8_t byte[3];
    rmap_xyz_to_rgb(xyz, linear);
    const double most = fmax(linear[0], fmax(linear[1], linear[2]));
    if (!(most > 0.0))
        return json_null();
    for (int k = 0; k < 3; k++)
        linear[k] /= most;
    rmap_srgb_encode(linear, byte);
    return json_pack("[i, i, i]", byte[0], byte[1], byte[2]);
}

json_t *rmap_detector_colour_json(const struct rmap_detector_colour *colour)
{
    const struct rmap_colour_reading *all = &colour->all;
    const struct rmap_chromaticity *of = &all->value, *error = &all->error;
    json_t *cri = colour->no_cri ? json_null()
                                 : json_pack("{s:o, s:o}", "Ra", rmap_json_number(all->general),
                                             "R", numbers(colour->cri.special, RMAP_CRI_SAMPLES));
    json_t *reason = json_object();
    if (colour->no_cct)
        (void)json_object_set_new(reason, "cct", json_string(colour->no_cct));
    if (colour->no_cri)
        (void)json_object_set_new(reason, "cri", json_string(colour->no_cri));
    json_t *errors =
        json_pack("{s:o, s:o, s:o, s:o, s:o}", "XYZ", numbers(all->xyz_error, 3), "xy",
                  numbers((const double[]){error->x, error->y}, 2), "uv",
                  numbers((const double[]){error->u, error->v}, 2), "cct",
                  rmap_json_number(error->kelvin), "duv", rmap_json_number(error->duv));
    return json_pack("{s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "unit", colour->unit,
                     "XYZ", numbers(all->xyz, 3), "xy", numbers((const double[]){of->x, of->y}, 2),
                     "uv", numbers((const double[]){of->u, of->v}, 2), "cct",
                     rmap_json_number(of->kelvin), "duv", rmap_json_number(of->duv), "cri", cri,
                     "sRGB", srgb_json(all->xyz), "reason", reason, "standard_error", errors);
}
