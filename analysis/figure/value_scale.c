/* SPDX-License-Identifier: MIT
 *
 * Which values a scale of false colours goes over.
 */
#include "analysis/figure/value_scale.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"

/* A logarithmic scale goes down to RMAP_LOG_DEPTH of the largest value, or further below the
 * smallest one by this part of its decades: a cell with one ray must look different from an empty
 * one. */
static const double LOG_MARGIN = 0.2;

/* The scale is logarithmic where half the lit cells lie below this part of the largest value: on a
 * linear one they are nearly black. */
static const double DARK_PART = 0.03;

static int ascending(const void *a, const void *b)
{
    double left = *(const double *)a, right = *(const double *)b;
    return (left > right) - (left < right);
}

double rmap_value_quantile(double *value, size_t n, double part)
{
    size_t n_lit = 0;
    for (size_t c = 0; c < n; c++)
        if (value[c] > 0.0)
            value[n_lit++] = value[c];
    qsort(value, n_lit, sizeof *value, ascending);
    return n_lit > 0 ? value[(size_t)((double)(n_lit - 1) * part)] : 0.0;
}

enum rmap_status rmap_value_scale_choose(const double *value, size_t n, double top,
                                         enum rmap_figure_scale asked, bool *logarithmic_ret,
                                         struct rmap_error *err)
{
    *logarithmic_ret = asked == RMAP_SCALE_LOGARITHMIC;
    if (asked != RMAP_SCALE_AUTO)
        return RMAP_OK;
    double *lit = rmap_alloc(n + 1, sizeof *lit);
    if (!lit)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a picture");
    memcpy(lit, value, n * sizeof *lit);
    const double middle = rmap_value_quantile(lit, n, 0.5);
    rmap_free(lit);
    *logarithmic_ret = middle > 0.0 && middle < DARK_PART * top;
    return RMAP_OK;
}

void rmap_value_scale_find(const double *value, size_t n, double top, bool logarithmic,
                           double range[2])
{
    double least = top;
    for (size_t c = 0; c < n; c++)
        if (value[c] > 0.0)
            least = fmin(least, value[c]);
    range[0] = 0.0;
    range[1] = top > 0.0 ? top : 1.0;
    if (logarithmic) {
        double depth = fmin(fmax(least / range[1], RMAP_LOG_DEPTH), 0.1);
        range[0] = range[1] * depth * pow(depth, LOG_MARGIN);
    }
}

double rmap_value_scale_sure(const double *value, const double *standard_error, size_t n,
                             double peak)
{
    double sure = 0.0, top = peak;
    for (size_t c = 0; c < n; c++)
        if (value[c] - 3.0 * standard_error[c] > sure) { /* not where the error is not known */
            sure = value[c] - 3.0 * standard_error[c];
            top = fmin(value[c] + standard_error[c], peak);
        }
    return top;
}
