/* SPDX-License-Identifier: MIT
 *
 * A field as a formula in x, y, z, r = |p|, rho = sqrt(x^2 + y^2) and lambda (um), compiled once
 * (muparser: + - * / ^, comparisons, c ? a : b, sin cos tan asin acos atan atan2 sinh cosh tanh exp
 * ln log log2 log10 sqrt abs sign rint min max sum avg; _pi, _e).
 */
#ifndef RMAP_FIELD_FORMULA_H
#define RMAP_FIELD_FORMULA_H

#include <stddef.h>

#include "base/status.h"
#include "gradient/field.h"

struct rmap_formula {
    const char *text;
    const char *slope[3]; /* of the field along x, y, z; NULL: differences of fourth order */
    size_t n_constant;
    const char *const *constant; /* names */
    const double *constant_value;
    double size;       /* of what the medium fills */
    double difference; /* that slopes are taken over; 0: 2e-5 of the size */
};

/* Copies what it needs. RMAP_INPUT with what is wrong with the formula and where in it. The field
 * has channels if the formula has lambda. wavelength_nm: [n_channel]. Threads take one of a pool of
 * compiled formulas for each evaluation. */
enum rmap_status rmap_field_formula(struct rmap_field **field_ret, int n_channel,
                                    const double *wavelength_nm, const struct rmap_formula *formula,
                                    struct rmap_error *err) RMAP_MUST_USE;

#endif
