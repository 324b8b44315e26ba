/* SPDX-License-Identifier: MIT
 *
 * Units that people write behind numbers: one table for scene files, criteria and maps.
 */
#ifndef RMAP_UNIT_H
#define RMAP_UNIT_H

#include <stdbool.h>
#include <stddef.h>

/* Exact by the SI of 2019: e in C; h c in eV nm, and in J nm. */
#define RMAP_EV_J  1.602176634e-19
#define RMAP_HC_EV 1239.8419843320025
#define RMAP_HC_J  1.9864458571489287e-16

/* What flux is counted in: power, or amounts of light. */
enum rmap_flux_unit {
    RMAP_FLUX_W,
    RMAP_FLUX_LM,
    RMAP_FLUX_PHOTON_RATE, /* photons/s */
    RMAP_FLUX_PHOTONS,
    RMAP_FLUX_J
};

/* What a number measures decides its units. */
enum rmap_dimension {
    RMAP_DIMENSION_NONE,
    RMAP_DIMENSION_LENGTH,
    RMAP_DIMENSION_ANGLE,
    RMAP_DIMENSION_WAVELENGTH, /* as LENGTH */
    RMAP_DIMENSION_TIME,
    RMAP_DIMENSION_FLUX,
    RMAP_DIMENSION_ENERGY, /* of a photon; and as FLUX in J */
    RMAP_DIMENSION_SHARE,  /* this and the next two: of scene files alone */
    RMAP_DIMENSION_TEMPERATURE,
    RMAP_DIMENSION_PER_LENGTH,
    RMAP_DIMENSION_MIXED /* of several detectors: each in its own unit */
};

struct rmap_written_unit {
    const char *name;
    enum rmap_dimension dimension;
    double size;                /* in m, degrees, s, W or lm ..., J, 1, K, 1/m */
    bool in_scene, in_criteria; /* may be written there */
    enum rmap_flux_unit flux;   /* FLUX */
};

const struct rmap_written_unit *rmap_unit_at(size_t i); /* NULL behind the last */

/* The unit of this name of `len` bytes; NULL: there is none. */
const struct rmap_written_unit *rmap_unit_named(const char *name, size_t len);

/* The same of one of this dimension that a scene file may have. */
const struct rmap_written_unit *rmap_unit_of_scene(const char *name, enum rmap_dimension dimension);

/* From one unit's size to another's. */
double rmap_unit_convert(double value, double from, double to);

#define RMAP_UNITS_MAX 32 /* of one dimension */
/* Their names in scene files, into word; how many there are. */
size_t rmap_unit_words(enum rmap_dimension dimension, const char *word[RMAP_UNITS_MAX]);

#endif
