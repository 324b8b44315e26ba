/* SPDX-License-Identifier: MIT
 *
 * Where the light of each source went: emitted = absorbed by objects and in media + left + limits
 * + errors, exact in rays.
 */
#ifndef RMAP_BALANCE_H
#define RMAP_BALANCE_H

#include <jansson.h>
#include <stdio.h>

#include "trace/tally.h"

/* RMAP_INTERNAL, naming the source, when the sums differ. */
enum rmap_status rmap_balance_check(const struct rmap_tally *tally,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* A table per source; the objects that absorbed most first. flux: [sources] of these rays; NULL:
 * that of the sources. */
void rmap_balance_print(const struct rmap_tally *tally, const double *flux, FILE *out);

/* [{"name", "emitted", "flux", "unit", "absorbed": {...}, "left", "limit", "error"}]; NULL when
 * memory is short. The counts are rays. */
json_t *rmap_balance_json(const struct rmap_tally *tally, const double *flux);

/* What each detector registered: a line each; [{"name", "registrations", "flux": {"total",
 * "standard_error", "unit"}}], NULL when memory is short. A registration is taken for a ray of its
 * own in the errors. */
void rmap_balance_print_detectors(const struct rmap_tally *tally, FILE *out);
json_t *rmap_balance_detectors_json(const struct rmap_tally *tally);

#endif
