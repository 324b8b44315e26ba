/* SPDX-License-Identifier: MIT
 *
 * The catalogue of optical materials: some 1,700 glasses of eight makers, crystals, plastics, films
 * and metals of the refractiveindex.info database (M. N. Polyanskiy, Scientific Data 11, 94 (2024),
 * doi:10.1038/s41597-023-02898-2; CC0). Its text, src/optics/materials.txt, is in the program and
 * read where it is asked for; jobs/pack-materials.py makes it.
 *
 * A map is read with its scene: numbers of a material that was released stay as they are.
 */
#ifndef RMAP_CATALOGUE_H
#define RMAP_CATALOGUE_H

#include "optics/glass.h"

/* A material's place in the text, and what was said before it. Zero: before the first. */
struct rmap_catalogue {
    const char *line, *group, *source, *at; /* each until the end of its line */
};

/* The next material; false behind the last. */
bool rmap_catalogue_next(struct rmap_catalogue *place);

void rmap_catalogue_read(const struct rmap_catalogue *place, struct rmap_glass *glass);

/* "N-BK7" and "SCHOTT", cut where they are too long. */
void rmap_catalogue_name(const struct rmap_catalogue *place, char name[32], char group[16]);

enum rmap_glass_found { RMAP_GLASS_UNKNOWN, RMAP_GLASS_FOUND, RMAP_GLASS_SEVERAL };

/* By name, with its group or without: "N-BK7", "SCHOTT N-BK7", "schott:n-bk7", in any case.
 * Without, SCHOTT's glass comes before those of other makers; of several others, `choices` names
 * all. */
enum rmap_glass_found rmap_glass_find(const char *name, struct rmap_glass *glass, char *choices,
                                      size_t choices_nbytes);

#endif
