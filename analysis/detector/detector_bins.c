/* SPDX-License-Identifier: MIT
 *
 * Into which cell of a picture what a detector registered falls: its own cells as they were
 * recorded, or any others, over its area or over the directions of the light.
 */
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "analysis/criterion/criterion_lex.h"
#include "analysis/criterion/criterion_parser.h"
#include "analysis/criterion/criterion_value.h"
#include "analysis/detector/detector_bins.h"

static double sine_squared(double angle)
{
    return sin(angle) * sin(angle);
}

void rmap_detector_bins_own(const struct rmap_scene *scene, int32_t index,
                            struct rmap_detector_bins *bins)
{
    const struct rmap_detector *detector = &scene->detector[index];
    const bool plane = detector->type == RMAP_DETECTOR_PLANE;
    *bins = (struct rmap_detector_bins){.detector = detector,
                                        .unit_m = scene->unit_m,
                                        .quantity = plane ? RMAP_PER_AREA : RMAP_PER_SOLID_ANGLE,
                                        .stored = true,
                                        .directions = !plane,
                                        .n = {detector->cells[0], detector->cells[1]},
                                        .high = {RMAP_PI, 2.0 * RMAP_PI},
                                        .cosine = 1.0};
    for (int k = 0; k < 2 && plane; k++) {
        bins->low[k] = -0.5 * detector->size[k];
        bins->high[k] = 0.5 * detector->size[k];
    }
}

rmap_column_set rmap_detector_bins_columns(const struct rmap_detector_bins *bins)
{
    if (bins->stored)
        return RMAP_COLUMN_BIT(RMAP_REGISTRATION_cell);
    if (bins->camera)
        return RMAP_COLUMN_BIT(RMAP_REGISTRATION_direction) |
               RMAP_COLUMN_BIT(RMAP_REGISTRATION_relative);
    return bins->directions ? RMAP_COLUMN_BIT(RMAP_REGISTRATION_direction)
                            : RMAP_COLUMN_BIT(RMAP_REGISTRATION_relative);
}

void rmap_detector_bins_place(const struct rmap_detector_bins *bins,
                              const struct rmap_portion *portion, size_t row, double *x, double *y)
{
    const uint16_t *relative = portion->registration.relative + 2 * row;
    *x = (relative[0] / 65535.0 - 0.5) * bins->detector->size[0];
    *y = (relative[1] / 65535.0 - 0.5) * bins->detector->size[1];
}

static void direction_of(const struct rmap_detector_bins *bins, const float *d, double uv[2])
{
    const struct rmap_detector *detector = bins->detector;
    const double sign = detector->type == RMAP_DETECTOR_PLANE ? -1.0 : 1.0;
    const struct rmap_vec3 v =
        rmap_scale(rmap_vec3((double)d[0], (double)d[1], (double)d[2]), sign);
    const double turn = 2.0 * RMAP_PI;
    const double x = rmap_dot(v, detector->x), y = rmap_dot(v, detector->y);
    uv[0] = atan2(hypot(x, y), rmap_dot(v, detector->axis));
    double phi = atan2(y, x) - bins->rotate_rad - bins->low[1];
    uv[1] = bins->low[1] + phi - turn * floor(phi / turn);
}

/* Through the place where the light crossed the opening, from that on the plane in focus. False: it
 * is not of the picture. */
static bool seen_from(const struct rmap_detector_bins *bins, const struct rmap_portion *portion,
                      size_t row, double uv[2])
{
    const struct rmap_detector *detector = bins->detector;
    const float *d = portion->registration.direction + 3 * row;
    const struct rmap_vec3 v = rmap_vec3(-(double)d[0], -(double)d[1], -(double)d[2]);
    const double ahead = rmap_dot(v, detector->axis);
    double x, y;
    rmap_detector_bins_place(bins, portion, row, &x, &y);
    uv[0] = rmap_dot(v, detector->x) / ahead + x / detector->camera.focus;
    uv[1] = rmap_dot(v, detector->y) / ahead + y / detector->camera.focus;
    return ahead > 0.0 && hypot(x, y) <= detector->camera.radius;
}

size_t rmap_detector_bins_cell(const struct rmap_detector_bins *bins,
                               const struct rmap_portion *portion, size_t row)
{
    size_t cell[2];
    double uv[2];
    if (bins->stored) {
        const uint16_t *at = portion->registration.cell + 2 * row;
        return at[0] < bins->n[0] && at[1] < bins->n[1] ? at[0] + (size_t)at[1] * bins->n[0]
                                                        : SIZE_MAX - 1;
    }
    if (bins->camera) {
        if (!seen_from(bins, portion, row, uv))
            return SIZE_MAX;
    } else if (bins->directions) {
        direction_of(bins, portion->registration.direction + 3 * row, uv);
    } else {
        double x, y;
        rmap_detector_bins_place(bins, portion, row, &x, &y);
        uv[0] = x * bins->cosine + y * bins->sine;
        uv[1] = y * bins->cosine - x * bins->sine;
    }
    for (int k = 0; k < 2; k++) {
        if (!(uv[k] >= bins->low[k] && uv[k] <= bins->high[k]))
            return SIZE_MAX;
        cell[k] = (size_t)((uv[k] - bins->low[k]) / (bins->high[k] - bins->low[k]) * bins->n[k]);
        cell[k] = cell[k] < bins->n[k] ? cell[k] : bins->n[k] - 1;
    }
    return cell[0] + cell[1] * bins->n[0];
}

/* Integral of |cos| sin over theta from 0. */
static double projected(double theta)
{
    double half = 0.5 * sine_squared(theta);
    return theta <= 0.5 * RMAP_PI ? half : 1.0 - half;
}

/* Of the directions that the detector registers: per unit of area, the solid angle weighted by the
 * cosine. */
static double acceptance(const struct rmap_detector *detector)
{
    double one = RMAP_PI * sine_squared(fmin(detector->max_angle_rad, 0.5 * RMAP_PI));
    return detector->side == RMAP_SIDE_BOTH ? 2.0 * one : one;
}

/* The extent of theta in [a, b] and phi over `turn`, or of an area. */
static double extent(const struct rmap_detector_bins *bins, double a, double b, double turn)
{
    const struct rmap_detector *detector = bins->detector;
    const double m2 = bins->unit_m * bins->unit_m;
    if (bins->quantity == RMAP_PER_CELL)
        return 1.0;
    if (!bins->directions)
        return (b - a) * turn * m2 *
               (bins->quantity == RMAP_PER_AREA_AND_ANGLE ? acceptance(detector) : 1.0);
    if (bins->quantity == RMAP_PER_AREA_AND_ANGLE)
        return (projected(b) - projected(a)) * turn * detector->size[0] * detector->size[1] * m2;
    /* cos a - cos b, without the cancellation near the poles */
    return 2.0 * sin(0.5 * (a + b)) * sin(0.5 * (b - a)) * turn;
}

/* Solid angle weighted by the cosine of the tangents [0, x] x [0, y]: the integral of
 * 1 / (1 + x^2 + y^2)^2. */
static double projected_to(double x, double y)
{
    const double a = sqrt(1.0 + x * x), b = sqrt(1.0 + y * y);
    return 0.5 * (x / a * atan(y / a) + y / b * atan(x / b));
}

/* Of the tangents [low, high]: from a point (x, y) of the opening one looks at what is in focus by
 * tangents that are smaller by x and y over its distance. Four points at 1/sqrt(2) of the radius
 * stand for the disc, exact to its third moments. */
static double camera_extent(const struct rmap_detector_bins *bins, const double low[2],
                            const double high[2])
{
    static const double point[4][2] = {{1.0, 0.0}, {-1.0, 0.0}, {0.0, 1.0}, {0.0, -1.0}};
    const struct rmap_detector_camera *camera = &bins->detector->camera;
    const double shift = sqrt(0.5) * camera->radius / camera->focus;
    const double area = RMAP_PI * camera->radius * camera->radius * bins->unit_m * bins->unit_m;
    double sum = 0.0;
    if (bins->quantity == RMAP_PER_CELL)
        return 1.0;
    for (int k = 0; k < 4; k++) {
        const double x[2] = {low[0] - shift * point[k][0], high[0] - shift * point[k][0]};
        const double y[2] = {low[1] - shift * point[k][1], high[1] - shift * point[k][1]};
        sum += projected_to(x[1], y[1]) - projected_to(x[0], y[1]) - projected_to(x[1], y[0]) +
               projected_to(x[0], y[0]);
    }
    return 0.25 * sum * area;
}

double rmap_detector_bins_extent(const struct rmap_detector_bins *bins, size_t cell)
{
    const double step[2] = {(bins->high[0] - bins->low[0]) / bins->n[0],
                            (bins->high[1] - bins->low[1]) / bins->n[1]};
    const double i = (double)(cell % bins->n[0]), j = (double)(cell / bins->n[0]);
    if (bins->camera)
        return camera_extent(
            bins, (const double[2]){bins->low[0] + i * step[0], bins->low[1] + j * step[1]},
            (const double[2]){bins->low[0] + (i + 1) * step[0], bins->low[1] + (j + 1) * step[1]});
    if (!bins->directions)
        return extent(bins, 0.0, step[0], step[1]);
    return extent(bins, bins->low[0] + i * step[0], bins->low[0] + (i + 1) * step[0], step[1]);
}

double rmap_detector_bins_whole(const struct rmap_detector_bins *bins)
{
    if (bins->camera)
        return camera_extent(bins, bins->low, bins->high);
    return extent(bins, bins->low[0], bins->high[0], bins->high[1] - bins->low[1]);
}

void rmap_detector_bins_centre(const struct rmap_detector_bins *bins, uint32_t i, uint32_t j,
                               double *x, double *y)
{
    const double degree = 180.0 / RMAP_PI;
    const double u = bins->low[0] + (i + 0.5) / bins->n[0] * (bins->high[0] - bins->low[0]);
    const double v = bins->low[1] + (j + 0.5) / bins->n[1] * (bins->high[1] - bins->low[1]);
    if (bins->stored && bins->directions) { /* exactly as recorded */
        *x = (i + 0.5) / bins->n[0] * 180.0;
        *y = (j + 0.5) / bins->n[1] * 360.0;
    } else if (bins->stored) {
        *x = ((i + 0.5) / bins->n[0] - 0.5) * bins->detector->size[0];
        *y = ((j + 0.5) / bins->n[1] - 0.5) * bins->detector->size[1];
    } else if (bins->directions) {
        *x = u * degree;
        *y = (v + bins->rotate_rad) * degree;
    } else {
        *x = u * bins->cosine - v * bins->sine;
        *y = u * bins->sine + v * bins->cosine;
    }
}

/* Cells, region and quantity of a detector's picture, as they are asked for on a command line. */

/* ---- region ---- */

enum { FIELD_NBYTES = 64 };

/* Where the unit begins; the end where there is none. */
static const char *unit_of(const char *field)
{
    const char *c = field;
    while (*c && !(isalpha((unsigned char)*c) &&
                   !(c > field && (*c == 'e' || *c == 'E') &&
                     (isdigit((unsigned char)c[1]) || c[1] == '-' || c[1] == '+'))))
        c++;
    return c;
}

/* "a..b" as the criterion language reads it. */
static enum rmap_status read_range(const struct rmap_scene *scene, enum rmap_dimension dimension,
                                   const char *text, double *low, double *high,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_criterion holder = {.scene = scene};
    struct rmap_parser parser = {.criterion = &holder, .text = text, .err = err};
    struct rmap_interval interval;
    RMAP_TRY(rmap_criterion_check_utf8(text, err));
    RMAP_TRY(rmap_parser_advance(&parser));
    RMAP_TRY(rmap_parse_range(&parser, dimension, rmap_unit_size_of(scene, dimension), &interval));
    if (parser.token.kind != RMAP_TOKEN_END)
        RMAP_TRY(rmap_parser_expected(&parser, "the end"));
    *low = interval.low;
    *high = interval.high;
out:
    return st;
}

/* A range in the world. */
static void to_detector(struct rmap_detector_bins *bins, int axis)
{
    const double from = rmap_detector_from_world(bins->detector, axis, bins->low[axis]);
    const double to = rmap_detector_from_world(bins->detector, axis, bins->high[axis]);
    bins->low[axis] = fmin(from, to);
    bins->high[axis] = fmax(from, to);
}

static enum rmap_status read_region(const struct rmap_scene *scene, const char *text, bool world,
                                    struct rmap_detector_bins *bins, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (world && (bins->rotate_rad != 0.0 || rmap_detector_along(bins->detector, 0) < 0 ||
                  rmap_detector_along(bins->detector, 1) < 0))
        return rmap_error_set(err, RMAP_USAGE,
                              "--region in the world: x and y of '%s' do not lie along axes of the "
                              "world; leave --frame world out, or ask by criteria with world_x, "
                              "world_y, world_z",
                              bins->detector->name);
    char field[4][FIELD_NBYTES] = {{0}}, range[2 * FIELD_NBYTES + 16];
    const enum rmap_dimension dimension =
        bins->directions ? RMAP_DIMENSION_ANGLE : RMAP_DIMENSION_LENGTH;
    size_t n = 0, at = 0;
    for (const char *c = text; *c && n < 4 && at < FIELD_NBYTES - 8; c++) {
        if (*c == ',') {
            n++;
            at = 0;
        } else {
            field[n][at++] = *c;
        }
    }
    if (n != 3 || !field[3][0])
        return rmap_error_set(err, RMAP_USAGE,
                              "--region '%.80s': give four numbers, as in -1,-1,1,1 mm or (over "
                              "directions: theta, phi) 0,0,30,360",
                              text);
    if (!*unit_of(field[1]) && !*unit_of(field[2])) /* one unit at the end is meant for all */
        (void)snprintf(field[2] + strlen(field[2]), 8, " %.6s", unit_of(field[3]));
    /* x0,y0,x1,y1 */
    for (int k = 0; k < 2; k++) {
        (void)snprintf(range, sizeof range, "%.60s..%.60s", field[k], field[k + 2]);
        RMAP_TRY(read_range(scene, dimension, range, &bins->low[k], &bins->high[k], err));
        if (bins->directions) {
            bins->low[k] *= RMAP_PI / 180.0;
            bins->high[k] *= RMAP_PI / 180.0;
        }
        if (world)
            to_detector(bins, k);
        if (!(bins->high[k] > bins->low[k]) || !isfinite(bins->high[k] - bins->low[k]))
            return rmap_error_set(err, RMAP_USAGE, "--region '%.80s' has no extent in %s", text,
                                  k == 0 ? "x" : "y");
    }
    if (bins->directions && (bins->low[0] < 0.0 || bins->high[0] > RMAP_PI * (1.0 + 1e-12) ||
                             bins->high[1] - bins->low[1] > 2.0 * RMAP_PI * (1.0 + 1e-12)))
        return rmap_error_set(err, RMAP_USAGE,
                              "--region '%.80s': theta is an angle from 0 to 180 degrees, and phi "
                              "goes round once",
                              text);
out:
    if (st == RMAP_INPUT) {
        rmap_criterion_relabel("--region", err);
        st = err ? err->status = RMAP_USAGE : RMAP_USAGE;
    }
    return st;
}

/* All of the detector, in axes turned as asked. */
static void cover(struct rmap_detector_bins *bins)
{
    const double *size = bins->detector->size;
    if (bins->directions) {
        const bool plane = bins->detector->type == RMAP_DETECTOR_PLANE;
        const bool front = plane && bins->detector->side == RMAP_SIDE_FRONT;
        bins->low[0] = bins->low[1] = 0.0;
        bins->high[0] = front ? 0.5 * RMAP_PI : RMAP_PI;
        bins->high[1] = 2.0 * RMAP_PI;
        return;
    }
    bins->high[0] = 0.5 * (fabs(bins->cosine) * size[0] + fabs(bins->sine) * size[1]);
    bins->high[1] = 0.5 * (fabs(bins->sine) * size[0] + fabs(bins->cosine) * size[1]);
    bins->low[0] = -bins->high[0];
    bins->low[1] = -bins->high[1];
}

/* ---- quantity ---- */

static const struct word {
    const char *word;
    enum rmap_detector_quantity quantity;
} word_table[] = {{"irradiance", RMAP_PER_AREA},
                  {"illuminance", RMAP_PER_AREA},
                  {"intensity", RMAP_PER_SOLID_ANGLE},
                  {"radiance", RMAP_PER_AREA_AND_ANGLE},
                  {"luminance", RMAP_PER_AREA_AND_ANGLE},
                  {"flux", RMAP_PER_CELL},
                  {"spectral", RMAP_PER_AREA},
                  {"daylight_factor", RMAP_PER_AREA}};

static enum rmap_status read_quantity(const struct rmap_detector_bins_asked *asked,
                                      struct rmap_detector_bins *bins, struct rmap_error *err)
{
    const struct word *found = NULL;
    const bool plane = bins->detector->type == RMAP_DETECTOR_PLANE;
    for (size_t i = 0; asked->quantity && i < sizeof word_table / sizeof *word_table; i++)
        if (strcmp(asked->quantity, word_table[i].word) == 0)
            found = &word_table[i];
    if (asked->quantity && !found)
        return rmap_error_set(err, RMAP_USAGE,
                              "--quantity '%.40s': say irradiance (illuminance), intensity, "
                              "radiance (luminance), flux, spectral or daylight_factor",
                              asked->quantity);
    if (asked->over && strcmp(asked->over, "area") != 0 && strcmp(asked->over, "direction") != 0)
        return rmap_error_set(err, RMAP_USAGE, "--over '%.40s': say area or direction",
                              asked->over);
    const bool spectral = asked->quantity && strcmp(asked->quantity, "spectral") == 0;
    const bool asks_area = asked->over && strcmp(asked->over, "area") == 0;
    if (found && !(spectral && !plane))
        bins->quantity = found->quantity;
    if (!plane &&
        (asks_area || bins->quantity == RMAP_PER_AREA || bins->quantity == RMAP_PER_AREA_AND_ANGLE))
        return rmap_error_set(err, RMAP_USAGE,
                              "'%s' is an intensity grid: it has directions and no area; lay a "
                              "plane over the map (--receivers) for what is per area",
                              bins->detector->name);
    if (plane)
        bins->directions = asked->over ? !asks_area : bins->quantity == RMAP_PER_SOLID_ANGLE;
    if (bins->directions && !found && plane)
        bins->quantity = RMAP_PER_SOLID_ANGLE;
    if (bins->directions && bins->quantity == RMAP_PER_AREA && spectral)
        bins->quantity = RMAP_PER_SOLID_ANGLE;
    if (bins->directions && bins->quantity == RMAP_PER_AREA)
        return rmap_error_set(err, RMAP_USAGE,
                              "irradiance is per area: leave out --over direction");
    if (!bins->directions && bins->quantity == RMAP_PER_SOLID_ANGLE)
        return rmap_error_set(err, RMAP_USAGE, "intensity is per direction: leave out --over area");
    return RMAP_OK;
}

/* All that the camera sees. */
static enum rmap_status read_picture(const struct rmap_detector_bins_asked *asked,
                                     struct rmap_detector_bins *bins, struct rmap_error *err)
{
    const struct rmap_detector_camera *camera = &bins->detector->camera;
    const bool turned = !isnan(asked->rotate_deg) && asked->rotate_deg != 0.0;
    if (asked->region || turned || asked->over || asked->world)
        return rmap_error_set(err, RMAP_USAGE,
                              "'%.60s' is a camera, whose picture is of all that it sees: it goes "
                              "with none of --region, --rotate, --over and --frame world",
                              bins->detector->name);
    if (bins->directions || (asked->quantity && bins->quantity == RMAP_PER_AREA &&
                             strcmp(asked->quantity, "spectral") != 0))
        return rmap_error_set(err, RMAP_USAGE,
                              "'%.60s' is a camera: it has luminance (radiance), flux or spectral",
                              bins->detector->name);
    if (bins->quantity == RMAP_PER_AREA)
        bins->quantity = RMAP_PER_AREA_AND_ANGLE;
    bins->camera = true;
    bins->stored = false;
    for (int k = 0; k < 2; k++) {
        bins->n[k] = asked->cells[0] ? asked->cells[k] : camera->pixels[k];
        bins->high[k] = camera->slope[k];
        bins->low[k] = -camera->slope[k];
    }
    return RMAP_OK;
}

/* Of any other detector, which is one of directions or not. */
static enum rmap_status read_cells(const struct rmap_scene *scene,
                                   const struct rmap_detector_bins_asked *asked, bool directed,
                                   struct rmap_detector_bins *bins, struct rmap_error *err)
{
    const bool turned = !isnan(asked->rotate_deg) && asked->rotate_deg != 0.0;
    enum rmap_status st = RMAP_OK;
    bins->stored = !asked->cells[0] && !asked->region && !turned && bins->directions == directed;
    if (bins->stored)
        return RMAP_OK;
    if (turned) {
        bins->rotate_rad = asked->rotate_deg * RMAP_PI / 180.0;
        bins->cosine = cos(bins->rotate_rad);
        bins->sine = sin(bins->rotate_rad);
    }
    cover(bins);
    if (asked->region)
        st = read_region(scene, asked->region, asked->world, bins, err);
    for (int k = 0; k < 2; k++)
        if (asked->cells[0])
            bins->n[k] = asked->cells[k];
        else if (bins->directions != directed) /* of 2 degrees */
            bins->n[k] =
                (uint32_t)fmax(ceil((bins->high[k] - bins->low[k]) * 90.0 / RMAP_PI - 1e-9), 1.0);
    return st;
}

enum rmap_status rmap_detector_bins_read(const struct rmap_scene *scene, int32_t detector,
                                         const struct rmap_detector_bins_asked *asked,
                                         struct rmap_detector_bins *bins, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    rmap_detector_bins_own(scene, detector, bins);
    const bool directed = bins->directions, sees = bins->detector->camera.radius > 0.0;
    RMAP_TRY(read_quantity(asked, bins, err));
    RMAP_TRY(sees ? read_picture(asked, bins, err) : read_cells(scene, asked, directed, bins, err));
    if ((uint64_t)bins->n[0] * bins->n[1] > RMAP_DETECTOR_CELLS_MAX && !bins->stored)
        st = rmap_error_set(err, RMAP_USAGE, "%u x %u cells are too many: %u at most", bins->n[0],
                            bins->n[1], RMAP_DETECTOR_CELLS_MAX);
out:
    return st;
}
