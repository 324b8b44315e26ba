/* SPDX-License-Identifier: MIT
 *
 * A luminaire's table of glare.
 */
#include "analysis/photometry/ugr_table.h"

#include <math.h>

#include "analysis/photometry/lamp_angles.h"
#include "analysis/photometry/position_index.h"
#include "io/export/json_number.h"

enum { FLOOR, WALLS, CEILING, PARTS };
enum { ZONES = 90, AROUND = 72, ROUNDS = 100 };

static const double height_m = 2.0, spacing = 0.25, gamma_most_deg = 85.0;
static const int room[RMAP_UGR_ROOMS][2] = {
    {2, 2}, {2, 3},  {2, 4}, {2, 6}, {2, 8}, {2, 12}, {4, 2},  {4, 3},  {4, 4}, {4, 6},
    {4, 8}, {4, 12}, {8, 4}, {8, 6}, {8, 8}, {8, 12}, {12, 4}, {12, 6}, {12, 8}};
static const double reflectances[RMAP_UGR_SURFACES][PARTS] = {
    {0.2, 0.5, 0.7}, {0.2, 0.3, 0.7}, {0.2, 0.5, 0.5}, {0.2, 0.3, 0.5}, {0.2, 0.3, 0.3}};

/* Between equal rectangles x, y that face each other at distance 1 (Hamilton and Morgan 1952, NACA
 * TN 2836). */
static double form_factor(double x, double y)
{
    const double a = sqrt(1.0 + x * x), b = sqrt(1.0 + y * y);
    return 2.0 / (RMAP_PI * x * y) *
           (log(a * b / sqrt(1.0 + x * x + y * y)) + x * b * atan(x / b) + y * a * atan(y / a) -
            x * atan(x) - y * atan(y));
}

void rmap_ugr_transfer(double x, double y, const double reflectance[3], double share[3])
{
    const double across = form_factor(x, y), side = 1.0 - across;
    const double area[PARTS] = {x * y, 2.0 * (x + y), x * y};
    const double back = side * area[FLOOR] / area[WALLS];
    const double factor[PARTS][PARTS] = {
        {0.0, side, across}, {back, 1.0 - 2.0 * back, back}, {across, side, 0.0}};
    for (int k = 0; k < PARTS; k++) {
        double first[PARTS] = {0.0}, all[PARTS] = {0.0};
        first[k] = 1.0 / area[k];
        for (int round = 0; round < ROUNDS; round++) {
            double next[PARTS];
            for (int i = 0; i < PARTS; i++) {
                next[i] = first[i];
                for (int j = 0; j < PARTS; j++)
                    next[i] += factor[i][j] * reflectance[j] * all[j];
            }
            for (int i = 0; i < PARTS; i++)
                all[i] = next[i];
        }
        share[k] = (all[WALLS] - first[WALLS]) * area[WALLS];
    }
}

/* Shares of the light that fall first on the floor, the walls and the ceiling: of a direction so
 * much comes to the floor as the floor and its shadow on it have in common. The lamp may hang
 * either way, so its intensity is the mean around. */
static void spread(const struct rmap_lamp *lamp, double x, double y, double share[PARTS])
{
    double down = 0.0;
    share[FLOOR] = 0.0;
    for (int z = 0; z < ZONES; z++) {
        const double gamma = (z + 0.5) * 0.5 * RMAP_PI / ZONES;
        double mean = 0.0, kept = 0.0;
        for (int k = 0; k < AROUND; k++) {
            const double c = (k + 0.5) * 2.0 * RMAP_PI / AROUND;
            mean += rmap_lamp_at(lamp, c * 180.0 / RMAP_PI, gamma * 180.0 / RMAP_PI) / AROUND;
            kept += fmax(1.0 - tan(gamma) * fabs(cos(c)) / x, 0.0) *
                    fmax(1.0 - tan(gamma) * fabs(sin(c)) / y, 0.0) / AROUND;
        }
        const double zone = 2.0 * RMAP_PI * sin(gamma) * 0.5 * RMAP_PI / ZONES;
        down += mean * zone;
        share[FLOOR] += mean * kept * zone;
    }
    share[WALLS] = down - share[FLOOR];
    share[CEILING] = fmax(1.0 - down, 0.0);
}

/* L^2 omega / p^2 of all luminaires, of unit flux, whose half plane C comes towards the observer.
 */
static double glare_of(const struct rmap_lamp *lamp, const int size[2], double c_deg, double unit_m)
{
    const int n[2] = {(int)lround(size[0] / spacing), (int)lround(size[1] / spacing)};
    double sum = 0.0;
    for (int i = 0; i < n[0]; i++)
        for (int j = 0; j < n[1]; j++) {
            const double aside = (i + 0.5) * spacing - 0.5 * size[0];
            const double ahead = (j + 0.5) * spacing, out = hypot(aside, ahead);
            const double gamma = atan(out) * 180.0 / RMAP_PI;
            const double turn = atan2(aside, ahead) * 180.0 / RMAP_PI;
            const double p = rmap_position_index(fabs(aside) / ahead, 1.0 / ahead);
            if (!(p > 0.0) || gamma > gamma_most_deg)
                continue;
            const struct rmap_vec3 way = rmap_lamp_direction(c_deg + turn, gamma);
            const double area = rmap_lamp_seen_area(lamp, way) * unit_m * unit_m;
            const double intensity = rmap_lamp_intensity(lamp, way);
            const double r2 = (out * out + 1.0) * height_m * height_m;
            if (area > 0.0)
                sum += intensity * intensity / (area * r2 * p * p);
        }
    return sum;
}

bool rmap_ugr_table_find(const struct rmap_lamp *lamp, double lumens, double unit_m,
                         struct rmap_ugr_table *table)
{
    if (lamp->body == RMAP_LAMP_POINT ||
        !(rmap_lamp_seen_area(lamp, rmap_lamp_direction(0.0, 45.0)) > 0.0))
        return false;
    for (int k = 0; k < RMAP_UGR_ROOMS; k++) {
        const double x = room[k][0], y = room[k][1], walls = 2.0 * (x + y) * height_m * height_m;
        const double n = x / spacing * y / spacing;
        double first[PARTS], glare[2];
        spread(lamp, x, y, first);
        for (int way = 0; way < 2; way++)
            glare[way] = fmax(glare_of(lamp, room[k], 90.0 * way, unit_m),
                              glare_of(lamp, room[k], 90.0 * way + 180.0, unit_m)) *
                         lumens * lumens;
        for (int c = 0; c < RMAP_UGR_COLUMNS; c++) {
            double share[PARTS], indirect = 0.0;
            rmap_ugr_transfer(x, y, reflectances[c % RMAP_UGR_SURFACES], share);
            for (int i = 0; i < PARTS; i++)
                indirect += first[i] * share[i];
            const double background = lumens * n / walls * indirect / RMAP_PI;
            const double sum = glare[c / RMAP_UGR_SURFACES];
            table->value[k][c] =
                sum > 0.0 && background > 0.0 ? 8.0 * log10(0.25 / background * sum) : (double)NAN;
        }
    }
    return true;
}

void rmap_ugr_table_print(const struct rmap_ugr_table *table, FILE *out)
{
    static const char *const name[PARTS] = {"floor", "walls", "ceiling"};
    static const int order[PARTS] = {CEILING, WALLS, FLOOR};
    fprintf(out, "UGR, CIE 190:2010, spacing 0.25 H\n%-10s %-32s%s\n", "", "crosswise", "endwise");
    for (int i = 0; i < PARTS; i++) {
        fprintf(out, "  %-8s", name[order[i]]);
        for (int c = 0; c < RMAP_UGR_COLUMNS; c++)
            fprintf(out, "%s%6.1f", c == RMAP_UGR_SURFACES ? "  " : "",
                    reflectances[c % RMAP_UGR_SURFACES][order[i]]);
        fputc('\n', out);
    }
    for (int k = 0; k < RMAP_UGR_ROOMS; k++) {
        fprintf(out, "  %2dH %2dH", room[k][0], room[k][1]);
        for (int c = 0; c < RMAP_UGR_COLUMNS; c++)
            fprintf(out, "%s%6.1f", c == RMAP_UGR_SURFACES ? "  " : "", table->value[k][c]);
        fputc('\n', out);
    }
}

json_t *rmap_ugr_table_json(const struct rmap_ugr_table *table)
{
    json_t *rooms = json_array(), *surfaces = json_array(),
           *value[2] = {json_array(), json_array()};
    for (int c = 0; c < RMAP_UGR_SURFACES; c++)
        (void)json_array_append_new(surfaces,
                                    json_pack("[f, f, f]", reflectances[c][CEILING],
                                              reflectances[c][WALLS], reflectances[c][FLOOR]));
    for (int k = 0; k < RMAP_UGR_ROOMS; k++) {
        (void)json_array_append_new(rooms, json_pack("[i, i]", room[k][0], room[k][1]));
        for (int way = 0; way < 2; way++) {
            json_t *row = json_array();
            for (int c = 0; c < RMAP_UGR_SURFACES; c++)
                (void)json_array_append_new(
                    row, rmap_json_number(table->value[k][RMAP_UGR_SURFACES * way + c]));
            (void)json_array_append_new(value[way], row);
        }
    }
    return json_pack("{s:f, s:o, s:o, s:o, s:o}", "spacing", spacing, "rooms", rooms,
                     "reflectances", surfaces, "crosswise", value[0], "endwise", value[1]);
}
