/* SPDX-License-Identifier: MIT
 *
 * Fields made of fields: sums, dispersion on top, a frame of their own.
 */
#ifndef RMAP_FIELD_MADE_H
#define RMAP_FIELD_MADE_H

#include "gradient/models.h"

/* n' = 1 + scale (n - 1) + offset, per channel. Dispersion on top of a model given at a reference
 * wavelength: additive {1, n_d(l) - n_d(ref)}; of gases {(n_d(l) - 1) / (n_d(ref) - 1), 0};
 * multiplicative {f, f - 1} with f = n_d(l) / n_d(ref). */
struct rmap_dispersed {
    double scale, offset;
};

/* n = base + sum of weight[i] (n_i - base): base 1 for indices (a hot plume in an atmosphere), 0
 * for scalars. weight NULL: all 1. */
enum rmap_status rmap_field_sum(struct rmap_field **field_ret, double base, int n_term,
                                struct rmap_field *const *term, const double *weight,
                                struct rmap_error *err) RMAP_MUST_USE;

/* The field in a frame of its own inside another's: n'(p) = n(to_local p). */
enum rmap_status rmap_field_placed(struct rmap_field **field_ret, struct rmap_field *of,
                                   const struct rmap_affine *to_local,
                                   struct rmap_error *err) RMAP_MUST_USE;

enum rmap_status rmap_field_dispersed(struct rmap_field **field_ret, struct rmap_field *of,
                                      int n_channel, const struct rmap_dispersed *parameter,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif
