/* SPDX-License-Identifier: MIT
 *
 * Where the bins of a number's distribution lie: many equal cells over all values are joined to
 * bins of about as many readings each, so that a spot in the middle of a wide field has its bins,
 * too.
 */
#include "analysis/compare/compare_cut.h"

void rmap_compare_cut_make(struct rmap_compare_cut *cut, const double *count, size_t n_most)
{
    const size_t per_shown = RMAP_COMPARE_CELLS / RMAP_COMPARE_SHOWN;
    double all = 0.0, held = 0.0;
    for (size_t c = 0; c < RMAP_COMPARE_CELLS; c++)
        all += count[c];
    /* Full bins are n_most - SHOWN at most, and each one shown may end with one that is not. */
    const double quota = all / (double)(n_most - RMAP_COMPARE_SHOWN);
    uint16_t bin = 0;
    for (size_t c = 0; c < RMAP_COMPARE_CELLS; c++) {
        const size_t next = c + 1;
        if (c % per_shown == 0)
            cut->shown[c / per_shown] = bin;
        cut->bin[c] = bin;
        held += count[c];
        if (next % per_shown == 0 || (held > 0.0 && held >= quota)) {
            bin++;
            held = 0.0;
        }
    }
    cut->shown[RMAP_COMPARE_SHOWN] = bin;
    cut->n_bin = bin;
}
