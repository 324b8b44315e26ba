/* SPDX-License-Identifier: MIT
 *
 * Data sheets of luminaires.
 */
#include "analysis/photometry/lamp_angles.h"

#include <math.h>
#include <string.h>

#include "analysis/table/text_table.h"
#include "io/export/json_number.h"

enum { STEPS = 360, HALVINGS = 50 }; /* of a quarter of a turn */

static const double usual_c[] = {0, 90, 180, 270};
static const double usual_gamma[] = {0,  5,  10, 15, 20, 25, 30,  35,  40,  45,  50,  55, 60,
                                     65, 70, 75, 80, 85, 90, 105, 120, 135, 150, 165, 180};
static const double usual_planes[] = {0, 90};

struct rmap_vec3 rmap_lamp_direction(double c_deg, double gamma_deg)
{
    const double c = c_deg * RMAP_PI / 180.0, gamma = gamma_deg * RMAP_PI / 180.0;
    return rmap_vec3(sin(gamma) * cos(c), -sin(gamma) * sin(c), cos(gamma));
}

double rmap_lamp_at(const struct rmap_lamp *lamp, double c_deg, double gamma_deg)
{
    return rmap_lamp_intensity(lamp, rmap_lamp_direction(c_deg, gamma_deg));
}

/* A plane by the signed angle to its axis, which looks down or up: above 0 on the side of C. */
struct section {
    const struct rmap_lamp *lamp;
    double c_deg;
    bool up;
};

static double at(const struct section *plane, double angle_deg)
{
    const double away = fabs(angle_deg);
    return rmap_lamp_at(plane->lamp, plane->c_deg + (angle_deg < 0.0 ? 180.0 : 0.0),
                        plane->up ? 180.0 - away : away);
}

/* The outermost angle on one side, 1 or -1, at which the intensity is `level`. */
static double edge(const struct section *plane, double side, double level)
{
    const double step = side * 90.0 / STEPS;
    int k = STEPS;
    if (at(plane, k * step) >= level)
        while (k < 2 * STEPS && at(plane, (k + 1) * step) >= level)
            k++;
    else
        while (k > -2 * STEPS && at(plane, k * step) < level)
            k--;
    if (k == 2 * STEPS)
        return k * step;
    double in = k * step, out = (k + 1) * step;
    for (int i = 0; i < HALVINGS; i++) {
        const double middle = 0.5 * (in + out);
        if (at(plane, middle) >= level)
            in = middle;
        else
            out = middle;
    }
    return in;
}

void rmap_lamp_plane_find(const struct rmap_lamp *lamp, double c_deg, struct rmap_lamp_plane *plane)
{
    struct section section = {lamp, c_deg, false};
    *plane = (struct rmap_lamp_plane){.c_deg = c_deg, .peak_c_deg = c_deg};
    for (int side = 1; side >= -1; side -= 2)
        for (int i = 0; i <= 2 * STEPS; i++) {
            const double gamma = i * 90.0 / STEPS, value = at(&section, side * gamma);
            if (!(value > plane->peak * (1.0 + 1e-9)))
                continue;
            plane->peak = value;
            plane->peak_c_deg = fmod(c_deg + (side < 0 ? 180.0 : 0.0), 360.0);
            plane->peak_gamma_deg = gamma;
        }
    section.up = plane->peak_gamma_deg > 90.0;
    for (int side = -1; side <= 1 && plane->peak > 0.0; side += 2) {
        plane->beam_deg += side * edge(&section, side, 0.5 * plane->peak);
        plane->field_deg += side * edge(&section, side, 0.1 * plane->peak);
    }
}

static bool is_luminous(const struct rmap_lamp_sheet *sheet)
{
    return strcmp(sheet->flux_unit, "lm") == 0;
}

void rmap_lamp_sheet_line(const struct rmap_lamp_sheet *sheet, FILE *out)
{
    struct rmap_lamp_plane plane[2];
    for (int k = 0; k < 2; k++)
        rmap_lamp_plane_find(sheet->lamp, usual_planes[k], &plane[k]);
    fprintf(out, "beam angle (50 %%) %.4g x %.4g deg, field angle (10 %%) %.4g x %.4g deg",
            plane[0].beam_deg, plane[1].beam_deg, plane[0].field_deg, plane[1].field_deg);
}

static void choose(const struct rmap_lamp_sheet *sheet, struct rmap_lamp_sheet *chosen)
{
    *chosen = *sheet;
    if (chosen->n_c == 0) {
        chosen->c_deg = usual_c;
        chosen->n_c = sizeof usual_c / sizeof *usual_c;
    }
    if (chosen->n_gamma == 0) {
        chosen->gamma_deg = usual_gamma;
        chosen->n_gamma = sizeof usual_gamma / sizeof *usual_gamma;
    }
}

static void print_planes(const struct rmap_lamp_sheet *sheet, FILE *out)
{
    fprintf(out, "%-10s %14s %10s %18s %18s\n", "plane", "greatest", "gamma", "beam angle, 50 %",
            "field angle, 10 %");
    for (int k = 0; k < 2; k++) {
        struct rmap_lamp_plane plane;
        rmap_lamp_plane_find(sheet->lamp, usual_planes[k], &plane);
        fprintf(out, "C%.0f-C%-5.0f %10.5g %s %6.4g deg %14.2f deg %14.2f deg\n", plane.c_deg,
                plane.c_deg + 180.0, plane.peak * sheet->flux, sheet->unit, plane.peak_gamma_deg,
                plane.beam_deg, plane.field_deg);
    }
}

/* Of unit flux; what rounding leaves at the edge of the light is none. */
static double shown(const struct rmap_lamp_sheet *sheet, size_t c, size_t gamma)
{
    const double value = rmap_lamp_at(sheet->lamp, sheet->c_deg[c], sheet->gamma_deg[gamma]);
    return value > 1e-12 ? value : 0.0;
}

enum rmap_status rmap_lamp_sheet_print(const struct rmap_lamp_sheet *asked, FILE *out,
                                       struct rmap_error *err)
{
    enum { COLUMNS_MOST = 37 };
    struct rmap_lamp_sheet sheet;
    struct rmap_text_table table;
    char alignment[2 * COLUMNS_MOST + 2];
    choose(asked, &sheet);
    if (sheet.n_c > COLUMNS_MOST)
        return rmap_error_set(err, RMAP_USAGE, "%zu planes C are too many for a table: %d at most",
                              sheet.n_c, COLUMNS_MOST);
    const bool per_klm = is_luminous(&sheet);
    print_planes(&sheet, out);
    fprintf(out, "\n%s%s\n", sheet.unit, per_klm ? ", and per 1000 lm" : "");
    memset(alignment, 'r', sizeof alignment);
    rmap_text_table_init(&table, 1 + sheet.n_c * (per_klm ? 2 : 1));
    rmap_text_table_add(&table, "gamma");
    for (int turn = 0; turn < (per_klm ? 2 : 1); turn++)
        for (size_t k = 0; k < sheet.n_c; k++)
            rmap_text_table_add(&table, "C%.6g%s", sheet.c_deg[k], turn ? "/klm" : "");
    for (size_t i = 0; i < sheet.n_gamma; i++) {
        rmap_text_table_add(&table, "%.6g", sheet.gamma_deg[i]);
        for (int turn = 0; turn < (per_klm ? 2 : 1); turn++)
            for (size_t k = 0; k < sheet.n_c; k++)
                rmap_text_table_add(&table, "%.5g",
                                    shown(&sheet, k, i) * (turn ? 1000.0 : sheet.flux));
    }
    const enum rmap_status st = rmap_text_table_print(&table, alignment, out, err);
    rmap_text_table_fini(&table);
    return st;
}

static json_t *planes_json(const struct rmap_lamp_sheet *sheet)
{
    json_t *list = json_array();
    for (int k = 0; k < 2; k++) {
        char name[32];
        struct rmap_lamp_plane plane;
        rmap_lamp_plane_find(sheet->lamp, usual_planes[k], &plane);
        (void)snprintf(name, sizeof name, "C%.0f-C%.0f", plane.c_deg, plane.c_deg + 180.0);
        (void)json_array_append_new(
            list, json_pack("{s:s, s:f, s:f, s:f, s:f, s:f}", "plane", name, "peak",
                            plane.peak * sheet->flux, "peak_C", plane.peak_c_deg, "peak_gamma",
                            plane.peak_gamma_deg, "beam_angle", plane.beam_deg, "field_angle",
                            plane.field_deg));
    }
    return list;
}

/* A row for each gamma. */
static json_t *intensities_json(const struct rmap_lamp_sheet *sheet, double flux)
{
    json_t *rows = json_array();
    for (size_t i = 0; i < sheet->n_gamma; i++) {
        json_t *row = json_array();
        for (size_t k = 0; k < sheet->n_c; k++)
            (void)json_array_append_new(row, rmap_json_number(flux * shown(sheet, k, i)));
        (void)json_array_append_new(rows, row);
    }
    return rows;
}

static json_t *numbers(const double *value, size_t n)
{
    json_t *list = json_array();
    for (size_t i = 0; i < n; i++)
        (void)json_array_append_new(list, json_real(value[i]));
    return list;
}

json_t *rmap_lamp_sheet_json(const struct rmap_lamp_sheet *asked, bool intensities)
{
    struct rmap_lamp_sheet sheet;
    choose(asked, &sheet);
    json_t *document =
        json_pack("{s:{s:f, s:s}, s:s, s:o}", "flux", "total", sheet.flux, "unit", sheet.flux_unit,
                  "unit", sheet.unit, "planes", planes_json(&sheet));
    if (!document || !intensities)
        return document;
    (void)json_object_set_new(document, "C", numbers(sheet.c_deg, sheet.n_c));
    (void)json_object_set_new(document, "gamma", numbers(sheet.gamma_deg, sheet.n_gamma));
    (void)json_object_set_new(document, "intensity", intensities_json(&sheet, sheet.flux));
    if (is_luminous(&sheet))
        (void)json_object_set_new(document, "per_klm", intensities_json(&sheet, 1000.0));
    return document;
}
