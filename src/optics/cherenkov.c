/* SPDX-License-Identifier: MIT
 *
 * Cherenkov light of a charged particle that is faster than light in its medium.
 */
#include "optics/cherenkov.h"

#include "base/vec.h"

#define FINE_STRUCTURE 7.2973525693e-3 /* CODATA 2018 */

double rmap_cherenkov_band(const double band_nm[2])
{
    return 2.0 * RMAP_PI * FINE_STRUCTURE * (1e9 / band_nm[0] - 1e9 / band_nm[1]);
}
