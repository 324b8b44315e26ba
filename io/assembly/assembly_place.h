/* SPDX-License-Identifier: MIT
 *
 * Places as people write them: `at`, `rotate` and `scale` where they say it, a `matrix` where they
 * do not.
 */
#ifndef RMAP_ASSEMBLY_PLACE_H
#define RMAP_ASSEMBLY_PLACE_H

#include <stdio.h>

#include "base/vec.h"

/* Each key behind `before`, nothing for the identity. reach: size of what is placed, in mm: numbers
 * are rounded as a person writes them where no point of it moves by more than about 1e-10 mm. */
void rmap_assembly_put_place(FILE *out, const char *before, const struct rmap_affine *place,
                             double reach);

#endif
