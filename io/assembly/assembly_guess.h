/* SPDX-License-Identifier: MIT
 *
 * What a part is taken to be made of, until a rule says better: paint of its colour, a metal, or a
 * glass where its material is one.
 */
#ifndef RMAP_ASSEMBLY_GUESS_H
#define RMAP_ASSEMBLY_GUESS_H

#include <stdio.h>

#include "io/assembly/assembly.h"

enum { RMAP_GUESS_NBYTES = 64 };

struct rmap_assembly_guess {
    char surface[RMAP_GUESS_NBYTES]; /* a name that says what it is: "paint_cc3300" */
    char inside[RMAP_GUESS_NBYTES];  /* a medium; "": it is opaque */
};

void rmap_assembly_guess(const struct rmap_assembly *assembly, const char *material,
                         const struct rmap_assembly_colour *colour, bool closed,
                         struct rmap_assembly_guess *guess);

/* "#cc3300" */
void rmap_assembly_hexadecimal(const struct rmap_assembly_colour *colour, char text[8]);

/* "  NAME: {...}" of a surface, and of a medium that is no glass of the catalogue (else nothing).
 */
void rmap_assembly_put_surface(FILE *out, const char *name);
bool rmap_assembly_put_medium(FILE *out, const char *name);

#endif
