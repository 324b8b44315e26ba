/* SPDX-License-Identifier: MIT
 *
 * Intensities at angles from fluxes in cells. A mean over a cell is not the intensity in its middle
 * where that has a kink there, as at every angle of a file, so means are solved for the intensities
 * that have them.
 */
#include "analysis/detector/far_field.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"

enum { SWEEPS = 60 }; /* each makes the error three times less */

void rmap_far_field_cells(const uint32_t n[2], uint32_t cells[2])
{
    cells[0] = 2 * n[0];
    cells[1] = 2 * n[1];
}

/* How n values in a row share their cells: cell i has weight[i][1] of value i, [0] of the one
 * before and [2] of the one behind. */
struct row {
    size_t n;
    bool around; /* the last is beside the first */
    const double (*weight)[3];
};

enum { PASSES = 30 };

/* What value i needs of what value i + 1 stands for (below 0: the other way), so that both cells
 * have their flux: what i sends into the other's cell less what that sends into its own. */
static double exchange_of(const struct row *row, const double *value, size_t i)
{
    const size_t next = (i + 1) % row->n;
    return row->weight[next][0] * value[i] - row->weight[i][2] * value[next];
}

/* Of what it gives, part[i] is as much as value i has. Parts only fall, pass by pass. */
static void limit(const double *flux, const double *exchange, size_t n, size_t n_between,
                  double *part, double *given, double *taken)
{
    for (size_t i = 0; i < n; i++)
        part[i] = 1.0;
    for (int pass = 0; pass < PASSES; pass++) {
        for (size_t i = 0; i < n; i++)
            taken[i] = given[i] = 0.0;
        for (size_t i = 0; i < n_between; i++) {
            const size_t next = (i + 1) % n, from = exchange[i] > 0.0 ? next : i;
            given[from] += fabs(exchange[i]);
            taken[from == i ? next : i] += part[from] * fabs(exchange[i]);
        }
        for (size_t i = 0; i < n; i++)
            if (part[i] * given[i] > flux[i] + taken[i])
                part[i] = (flux[i] + taken[i]) / given[i];
    }
}

/* Where values are below 0, neighbours exchange no more flux than they have (flux-corrected
 * transport: Zalesak 1979, doi:10.1016/0021-9991(79)90051-2): the sum over all cells stays, and so
 * do values that have enough. flux >= 0; room: [4 n]. What was not exchanged, in parts of a flux.
 */
static double keep_positive(const struct row *row, const double *flux, double *value, double *room)
{
    const size_t n = row->n, n_between = row->around ? n : n - 1;
    double *part = room, *given = part + n, *taken = given + n, *exchange = taken + n;
    double kept = 0.0;
    bool good = true;
    for (size_t i = 0; i < n; i++)
        good = good && value[i] >= 0.0;
    if (good)
        return 0.0;
    for (size_t i = 0; i < n_between; i++)
        exchange[i] = exchange_of(row, value, i);
    limit(flux, exchange, n, n_between, part, given, taken);
    memcpy(value, flux, n * sizeof *value);
    for (size_t i = 0; i < n_between; i++) {
        const size_t next = (i + 1) % n, from = exchange[i] > 0.0 ? next : i;
        value[i] += part[from] * exchange[i];
        value[next] -= part[from] * exchange[i];
        kept += (1.0 - part[from]) * fabs(exchange[i]);
    }
    for (size_t i = 0; i < n; i++) {
        const double before = row->around || i > 0 ? row->weight[(i + n - 1) % n][2] : 0.0,
                     behind = row->around || i + 1 < n ? row->weight[(i + 1) % n][0] : 0.0;
        value[i] = fmax(value[i], 0.0) / (before + row->weight[i][1] + behind);
    }
    return kept;
}

/* Flux of the cells about angle i and plane k, lm, over the step of C. C goes against phi. */
static double flux_of(const struct rmap_detector_image *image, size_t i, size_t k)
{
    const size_t n_theta = image->n[0], n_phi = image->n[1];
    double flux = 0.0;
    for (size_t side = 0; side < 2; side++)
        for (size_t half = 0; half < 2; half++) {
            const size_t t = 2 * i + half, p = (n_phi - 2 * k + n_phi - side) % n_phi;
            if (t > 0 && t <= n_theta)
                flux += image->value[(t - 1) + p * n_theta] *
                        rmap_detector_bins_extent(&image->bins, t - 1);
        }
    return flux / (2.0 * RMAP_PI / (0.5 * (double)n_phi));
}

/* Means over C of what is linear between the planes have an eighth of each neighbour's. */
static void solve_around(const double *mean, size_t n, double *value)
{
    memcpy(value, mean, n * sizeof *value);
    for (int sweep = 0; sweep < SWEEPS; sweep++)
        for (size_t k = 0; k < n; k++)
            value[k] = (8.0 * mean[k] - value[(k + n - 1) % n] - value[(k + 1) % n]) / 6.0;
}

/* Integrals over gamma cell i of the sine times what is 1 at one angle and 0 at those beside it: at
 * the angle before, its own, and the next. */
static void weights_of(size_t i, size_t n_step, double weight[3])
{
    const double step = RMAP_PI / (double)n_step, middle = step * (double)i,
                 from = i > 0 ? middle - 0.5 * step : 0.0,
                 to = i < n_step ? middle + 0.5 * step : middle;
    /* of (gamma - middle) sin gamma */
    const double before = sin(middle) - sin(from) + (from - middle) * cos(from),
                 behind = sin(to) - (to - middle) * cos(to) - sin(middle);
    weight[0] = -before / step;
    weight[2] = behind / step;
    weight[1] = cos(from) - cos(to) - weight[0] - weight[2];
}

/* flux, value: [n_plane][n_step + 1]; at the poles all planes have one value. */
static void solve_along(const double *flux, size_t n_plane, size_t n_step, double *value)
{
    double weight[3];
    for (int sweep = 0; sweep < SWEEPS; sweep++)
        for (size_t i = 0; i <= n_step; i++) {
            double mean = 0.0;
            weights_of(i, n_step, weight);
            for (size_t k = 0; k < n_plane; k++) {
                const size_t at = k * (n_step + 1) + i;
                value[at] = (flux[at] - (i > 0 ? weight[0] * value[at - 1] : 0.0) -
                             (i < n_step ? weight[2] * value[at + 1] : 0.0)) /
                            weight[1];
                mean += value[at] / (double)n_plane;
            }
            for (size_t k = 0; k < n_plane && (i == 0 || i == n_step); k++)
                value[k * (n_step + 1) + i] = mean;
        }
}

/* The same of values that are not below 0; weight: [n_step + 1]. */
static double keep_along(double *flux, size_t n_plane, size_t n_step, const double (*weight)[3],
                         double *value, double *room)
{
    const struct row row = {n_step + 1, false, weight};
    double kept = 0.0;
    for (size_t i = 0; i <= n_step; i += n_step) { /* the poles' flux is of all planes */
        double mean = 0.0;
        for (size_t k = 0; k < n_plane; k++)
            mean += flux[k * row.n + i] / (double)n_plane;
        for (size_t k = 0; k < n_plane; k++)
            flux[k * row.n + i] = mean;
    }
    for (size_t k = 0; k < n_plane; k++)
        kept += keep_positive(&row, flux + k * row.n, value + k * row.n, room);
    for (size_t i = 0; i <= n_step; i += n_step) {
        double mean = 0.0;
        for (size_t k = 0; k < n_plane; k++)
            mean += value[k * row.n + i] / (double)n_plane;
        for (size_t k = 0; k < n_plane; k++)
            value[k * row.n + i] = mean;
    }
    return kept;
}

/* Flux per step of C that values send, linear between the angles. */
static double sent_by(const struct rmap_lamp_file *file, const double (*weight)[3])
{
    const size_t n = file->n_polar;
    double sum = 0.0;
    for (size_t c = 0; c < n * file->n_around; c++) {
        const size_t i = c % n;
        sum += file->candela[c] * (weight[i][1] + (i > 0 ? weight[i - 1][2] : 0.0) +
                                   (i + 1 < n ? weight[i + 1][0] : 0.0));
    }
    return sum;
}

/* room: flux [n], then mean and value [n_plane], then what keep_positive wants. Ret: the part of
 * the flux that lies in other cells than it was measured in. */
static double fit(const struct rmap_detector_image *image, struct rmap_lamp_file *file,
                  double (*weight)[3], double *room)
{
    const size_t n_step = file->n_polar - 1, n_plane = file->n_around, n = n_plane * file->n_polar;
    double *flux = room, *mean = flux + n, *value = mean + n_plane, *rest = value + n_plane;
    double kept = 0.0, all = 0.0;
    for (size_t k = 0; k < n_plane; k++) {
        weight[k][0] = weight[k][2] = 0.125;
        weight[k][1] = 0.75;
    }
    for (size_t i = 0; i <= n_step; i++) {
        for (size_t k = 0; k < n_plane; k++) {
            mean[k] = flux_of(image, i, k);
            all += mean[k];
        }
        solve_around(mean, n_plane, value);
        const struct row row = {n_plane, true, (const double(*)[3])weight};
        kept += keep_positive(&row, mean, value, rest);
        for (size_t k = 0; k < n_plane; k++)
            flux[k * (n_step + 1) + i] = value[k];
    }
    solve_along(flux, n_plane, n_step, file->candela);
    for (size_t i = 0; i <= n_step; i++)
        weights_of(i, n_step, weight[i]);
    kept += keep_along(flux, n_plane, n_step, (const double(*)[3])weight, file->candela, rest);
    const double sent = sent_by(file, (const double(*)[3])weight);
    for (size_t c = 0; c < n && sent > 0.0; c++) /* rounding, and passes that did not suffice */
        file->candela[c] *= all / sent;
    return all > 0.0 ? kept / all : 0.0;
}

enum rmap_status rmap_far_field_fit(const struct rmap_detector_image *image,
                                    struct rmap_lamp_file *file, double *moved_ret,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n_step = image->n[0] / 2, n_plane = image->n[1] / 2, n = n_plane * (n_step + 1),
                 most = n_plane > n_step ? n_plane : n_step + 1;
    *file = (struct rmap_lamp_file){.n_around = n_plane, .n_polar = n_step + 1};
    file->around_deg = rmap_alloc(n_plane, sizeof *file->around_deg);
    file->polar_deg = rmap_alloc(n_step + 1, sizeof *file->polar_deg);
    file->candela = rmap_alloc(n, sizeof *file->candela);
    double *room = rmap_alloc(n + 2 * n_plane + 4 * most, sizeof *room);
    double(*weight)[3] = rmap_alloc(most, sizeof *weight);
    if (!file->around_deg || !file->polar_deg || !file->candela || !room || !weight)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a lamp's file"));
    for (size_t k = 0; k < n_plane; k++)
        file->around_deg[k] = 360.0 * (double)k / (double)n_plane;
    for (size_t i = 0; i <= n_step; i++)
        file->polar_deg[i] = 180.0 * (double)i / (double)n_step;
    *moved_ret = fit(image, file, weight, room);
out:
    rmap_free(room);
    rmap_free(weight);
    return st;
}
