/* SPDX-License-Identifier: MIT
 *
 * Shapes of Zemax's surfaces, by their type and the numbers that stand in PARM and XDAT.
 */
#ifndef RMAP_LENS_ZMX_SHAPE_H
#define RMAP_LENS_ZMX_SHAPE_H

#include "io/lensfile/prescription.h"

enum { RMAP_ZMX_PARAMETERS = 16, RMAP_ZMX_EXTRA = RMAP_LENS_TERMS_MAX + 3 };

struct rmap_zmx_numbers {
    double parameter[RMAP_ZMX_PARAMETERS + 1]; /* PARM, from 1 */
    double extra[RMAP_ZMX_EXTRA + 1];          /* XDAT, from 1 */
};

/* Fills the shape of a surface whose `type` is set and whose lines are all read. */
void rmap_zmx_shape(struct rmap_prescription *lens, struct rmap_lens_surface *surface,
                    const struct rmap_zmx_numbers *numbers);

#endif
