/* SPDX-License-Identifier: MIT
 *
 * How likely chance alone makes a difference as large as the one seen: p-values, and their
 * correction where many are looked at.
 */
#ifndef RMAP_SIGNIFICANCE_H
#define RMAP_SIGNIFICANCE_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

/* P(X >= value) for a chi-square distribution of `degrees` > 0; value >= 0. */
double rmap_significance_chi_square(double value, double degrees);

/* P(|Z| >= |z|) of the normal distribution. */
double rmap_significance_normal(double z);

/* Two-sided: of n draws with chance `share` in (0, 1), as far out as `hits` of them or farther;
 * twice the smaller tail, at most 1. Takes as many steps as draws are expected on the rarer
 * side. */
double rmap_significance_binomial(uint64_t hits, uint64_t n, double share);

enum rmap_correction {
    RMAP_CORRECTION_HOLM,
    RMAP_CORRECTION_SIDAK,
    RMAP_CORRECTION_NONE,
    RMAP_CORRECTION_COUNT
};
extern const char *const rmap_correction_word[RMAP_CORRECTION_COUNT + 1]; /* ends with NULL */

/* p-values of a family of n tests, so that the chance of a false alarm among all of them is that of
 * a single one. Holm (1979): whatever the tests have to do with each other. Sidak (1967,
 * doi:10.1080/01621459.1967.10482935): 1 - (1 - p)^n, of independent ones. NaN stays, and does not
 * count. RMAP_SYSTEM. */
enum rmap_status rmap_significance_correct(enum rmap_correction correction, const double *p,
                                           size_t n, double *adjusted,
                                           struct rmap_error *err) RMAP_MUST_USE;

#endif
