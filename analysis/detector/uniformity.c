/* SPDX-License-Identifier: MIT
 *
 * How evenly light falls on the cells of an image.
 */
#include "analysis/detector/uniformity.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/rng.h"
#include "base/vec.h"

const int rmap_percentile[RMAP_PERCENTILES] = {5, 25, 50, 75, 95};

/* Draws of all cells together, and those of one. */
enum { DRAWS = 2000000, REPEATS_MIN = 20, REPEATS_MAX = 200 };

/* In standard errors: a cell that is further from the least or greatest is neither. */
static const double reach = 6.0;

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Cells that may become the least or the greatest; where the least is nothing, which has no error
 * that could be told, the greatest alone. Places are of those that may become either: a cell's
 * noise is the same in both cases, and so is the number of repeats. */
struct cells {
    size_t n, n_place;
    double *value, *error; /* [n] */
    size_t *place;         /* [n] */
};

static void choose(const double *value, const double *error, size_t n, bool least_is_known,
                   struct cells *cells)
{
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (size_t i = 0; i < n; i++) {
        low = fmin(low, value[i] + reach * error[i]);
        high = fmax(high, value[i] - reach * error[i]);
    }
    for (size_t i = 0; i < n; i++) {
        const bool may_be_least = value[i] - reach * error[i] <= low,
                   may_be_greatest = value[i] + reach * error[i] >= high;
        const size_t place = cells->n_place;
        cells->n_place += may_be_least || may_be_greatest;
        if (!may_be_greatest && !(may_be_least && least_is_known))
            continue;
        cells->value[cells->n] = value[i];
        cells->error[cells->n] = error[i];
        cells->place[cells->n++] = place;
    }
}

/* Of a repeat: the least and the greatest of the cells with their noise once more. */
static void draw(const struct cells *cells, uint32_t repeat, double *least, double *greatest)
{
    double u[4], normal[4] = {0.0};
    size_t four = SIZE_MAX;
    *least = HUGE_VAL;
    *greatest = -HUGE_VAL;
    for (size_t i = 0; i < cells->n; i++) {
        if (cells->place[i] / 4 != four) {
            four = cells->place[i] / 4;
            rmap_rng(0, four, repeat, RMAP_RNG_NOISE, u);
            for (int k = 0; k < 4; k += 2) { /* Box and Muller 1958 */
                const double r = sqrt(-2.0 * log(u[k]));
                normal[k] = r * cos(2.0 * RMAP_PI * u[k + 1]);
                normal[k + 1] = r * sin(2.0 * RMAP_PI * u[k + 1]);
            }
        }
        /* No cell has less than nothing. */
        const double x = fmax(cells->value[i] + cells->error[i] * normal[cells->place[i] % 4], 0.0);
        *least = fmin(*least, x);
        *greatest = fmax(*greatest, x);
    }
}

/* Of a number over the repeats, less what it was without them. */
struct repeats {
    double sum, square;
};

static void count(struct repeats *of, double x)
{
    of->sum += x;
    of->square += x * x;
}

/* Errors are those that were measured on fields whose truth is known (unit.test_uniformity). */
static void conclude(const struct repeats *of, int n, struct rmap_biased *result)
{
    const double mean = of->sum / n;
    result->bias = mean / (sqrt(2.0) - 1.0);
    result->standard_error = 2.0 * sqrt(fmax(of->square / n - mean * mean, 0.0));
}

static void repeat_all(const struct cells *cells, double mean, struct rmap_uniformity *uniformity)
{
    const size_t fit = DRAWS / (cells->n_place + 1);
    const int n = fit < REPEATS_MIN ? REPEATS_MIN : fit > REPEATS_MAX ? REPEATS_MAX : (int)fit;
    struct repeats least = {0}, greatest = {0}, u0 = {0}, ud = {0};
    for (int r = 0; r < n; r++) {
        double low, high;
        draw(cells, (uint32_t)r, &low, &high);
        count(&least, low - uniformity->least.value);
        count(&greatest, high - uniformity->greatest.value);
        count(&u0, low / mean - uniformity->u0.value);
        count(&ud, low / high - uniformity->ud.value);
    }
    conclude(&least, n, &uniformity->least);
    conclude(&greatest, n, &uniformity->greatest);
    conclude(&u0, n, &uniformity->u0);
    conclude(&ud, n, &uniformity->ud);
}

enum rmap_status rmap_uniformity_find(const double *value, const double *standard_error, size_t n,
                                      double mean, struct rmap_uniformity *uniformity,
                                      struct rmap_error *err)
{
    const double nan = (double)NAN;
    bool known = mean > 0.0;
    struct cells cells = {.value = rmap_alloc(n, sizeof(double)),
                          .error = rmap_alloc(n, sizeof(double)),
                          .place = rmap_alloc(n, sizeof(size_t))};
    double *sorted = rmap_alloc(n, sizeof *sorted);
    enum rmap_status st = RMAP_OK;
    if (!cells.value || !cells.error || !cells.place || !sorted) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu cells", n);
        goto out;
    }
    memcpy(sorted, value, n * sizeof *sorted);
    qsort(sorted, n, sizeof *sorted, compare);
    *uniformity = (struct rmap_uniformity){.least = {sorted[0], nan, nan},
                                           .greatest = {sorted[n - 1], nan, nan},
                                           .u0 = {sorted[0] / mean, nan, nan},
                                           .ud = {sorted[0] / sorted[n - 1], nan, nan}};
    for (int k = 0; k < RMAP_PERCENTILES; k++) /* the nearest rank */
        uniformity->percentile[k] =
            sorted[(size_t)(rmap_percentile[k] / 100.0 * (double)(n - 1) + 0.5)];
    for (size_t i = 0; i < n; i++)
        known = known && isfinite(standard_error[i]);
    if (known) {
        choose(value, standard_error, n, sorted[0] > 0.0, &cells);
        repeat_all(&cells, mean, uniformity);
    }
    if (!(sorted[0] > 0.0)) { /* how uncertain nothing is, it does not say */
        uniformity->least = (struct rmap_biased){sorted[0], nan, nan};
        uniformity->u0 = (struct rmap_biased){sorted[0] / mean, nan, nan};
        uniformity->ud = (struct rmap_biased){sorted[0] / sorted[n - 1], nan, nan};
    }
out:
    rmap_free(sorted);
    rmap_free(cells.value);
    rmap_free(cells.error);
    rmap_free(cells.place);
    return st;
}
