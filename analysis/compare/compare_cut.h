/* SPDX-License-Identifier: MIT
 *
 * Where the bins of a number's distribution lie: many equal cells over all values are joined to
 * bins of about as many readings each, so that a spot in the middle of a wide field has its bins,
 * too. No bin crosses the borders of the few equal ones that a picture shows.
 */
#ifndef RMAP_COMPARE_CUT_H
#define RMAP_COMPARE_CUT_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

#define RMAP_COMPARE_SHOWN 50
/* A detector's coordinates have 65,535 steps. A multiple of the bins shown. */
#define RMAP_COMPARE_CELLS ((size_t)2621 * RMAP_COMPARE_SHOWN)

/* Plain data; its bytes may be sent. */
struct rmap_compare_cut {
    uint32_t n_bin;
    uint16_t bin[RMAP_COMPARE_CELLS];       /* of a cell */
    uint16_t shown[RMAP_COMPARE_SHOWN + 1]; /* the first bin of each one shown; n_bin */
};

/* count[RMAP_COMPARE_CELLS]: readings; at most n_most bins, of more than RMAP_COMPARE_SHOWN. */
void rmap_compare_cut_make(struct rmap_compare_cut *cut, const double *count, size_t n_most);

#endif
