/* SPDX-License-Identifier: MIT
 *
 * How evenly light falls on the cells of an image: least, greatest, percentiles, and the
 * uniformities of EN 12464-1, U0 = least / mean and Ud = least / greatest.
 *
 * The least of many noisy cells lies too low, the greatest too high. By how much is found by
 * simulation and extrapolation (Cook and Stefanski 1994, doi:10.1080/01621459.1994.10476871): the
 * cells' noise is added once more, which makes it sqrt(2) times as large, and what that changes is
 * continued, in proportion to the noise, to none. Noise of cells is taken for independent and
 * normal, with their standard errors.
 */
#ifndef RMAP_UNIFORMITY_H
#define RMAP_UNIFORMITY_H

#include <stddef.h>

#include "base/status.h"

#define RMAP_PERCENTILES 5
extern const int rmap_percentile[RMAP_PERCENTILES]; /* 5 25 50 75 95 */

/* value: as the cells are. bias: what their noise adds on average; value - bias is the estimate
 * without, with this standard error. NaN where errors are not known, or a least cell is empty. */
struct rmap_biased {
    double value, bias, standard_error;
};

struct rmap_uniformity {
    struct rmap_biased least, greatest, u0, ud;
    double percentile[RMAP_PERCENTILES];
};

/* value, standard_error: [n], n > 0. mean: of the whole area. */
enum rmap_status rmap_uniformity_find(const double *value, const double *standard_error, size_t n,
                                      double mean, struct rmap_uniformity *uniformity,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
