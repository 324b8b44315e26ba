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

enum rmap_status rmap_far_field_fit(const struct rmap_detector_image *image,
                                    struct rmap_lamp_file *file, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n_step = image->n[0] / 2, n_plane = image->n[1] / 2, n = n_plane * (n_step + 1);
    *file = (struct rmap_lamp_file){.n_around = n_plane, .n_polar = n_step + 1};
    file->around_deg = rmap_alloc(n_plane, sizeof *file->around_deg);
    file->polar_deg = rmap_alloc(n_step + 1, sizeof *file->polar_deg);
    file->candela = rmap_alloc(n, sizeof *file->candela);
    double *flux = rmap_alloc(n + 2 * n_plane, sizeof *flux), *mean = flux + n,
           *value = mean + n_plane;
    if (!file->around_deg || !file->polar_deg || !file->candela || !flux)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a lamp's file"));
    for (size_t k = 0; k < n_plane; k++)
        file->around_deg[k] = 360.0 * (double)k / (double)n_plane;
    for (size_t i = 0; i <= n_step; i++) {
        file->polar_deg[i] = 180.0 * (double)i / (double)n_step;
        for (size_t k = 0; k < n_plane; k++)
            mean[k] = flux_of(image, i, k);
        solve_around(mean, n_plane, value);
        for (size_t k = 0; k < n_plane; k++)
            flux[k * (n_step + 1) + i] = value[k];
    }
    solve_along(flux, n_plane, n_step, file->candela);
    for (size_t i = 0; i < n; i++)
        file->candela[i] = fmax(file->candela[i], 0.0);
out:
    rmap_free(flux);
    return st;
}
