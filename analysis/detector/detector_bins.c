/* SPDX-License-Identifier: MIT */
#include "analysis/detector/detector_bins.h"

#include <math.h>

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
    if (bins->directions) {
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

double rmap_detector_bins_extent(const struct rmap_detector_bins *bins, uint32_t i)
{
    const double step[2] = {(bins->high[0] - bins->low[0]) / bins->n[0],
                            (bins->high[1] - bins->low[1]) / bins->n[1]};
    if (!bins->directions)
        return extent(bins, 0.0, step[0], step[1]);
    return extent(bins, bins->low[0] + i * step[0], bins->low[0] + (i + 1) * step[0], step[1]);
}

double rmap_detector_bins_whole(const struct rmap_detector_bins *bins)
{
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
