/* SPDX-License-Identifier: MIT
 *
 * The table of units.
 */
#include "base/unit.h"

#include <math.h>
#include <string.h>

#include "base/vec.h"

static const struct rmap_written_unit unit_table[] = {
    {"pm", RMAP_DIMENSION_LENGTH, 1e-12, false, true},
    {"nm", RMAP_DIMENSION_LENGTH, 1e-9, true, true},
    {"um", RMAP_DIMENSION_LENGTH, 1e-6, true, true},
    {"mm", RMAP_DIMENSION_LENGTH, 1e-3, true, true},
    {"cm", RMAP_DIMENSION_LENGTH, 1e-2, true, true},
    {"m", RMAP_DIMENSION_LENGTH, 1.0, true, true},
    {"km", RMAP_DIMENSION_LENGTH, 1e3, false, true},
    {"in", RMAP_DIMENSION_LENGTH, 0.0254, true, true},
    {"deg", RMAP_DIMENSION_ANGLE, 1.0, true, true},
    {"rad", RMAP_DIMENSION_ANGLE, 180.0 / RMAP_PI, true, true},
    {"mrad", RMAP_DIMENSION_ANGLE, 0.18 / RMAP_PI, true, true},
    {"s", RMAP_DIMENSION_TIME, 1.0, true, true},
    {"ms", RMAP_DIMENSION_TIME, 1e-3, true, true},
    {"us", RMAP_DIMENSION_TIME, 1e-6, true, true},
    {"ns", RMAP_DIMENSION_TIME, 1e-9, true, true},
    {"ps", RMAP_DIMENSION_TIME, 1e-12, true, true},
    {"fs", RMAP_DIMENSION_TIME, 1e-15, false, true},
    {"min", RMAP_DIMENSION_TIME, 60.0, true, false},
    {"h", RMAP_DIMENSION_TIME, 3600.0, true, false},
    {"W", RMAP_DIMENSION_FLUX, 1.0, true, true},
    {"uW", RMAP_DIMENSION_FLUX, 1e-6, true, true},
    {"mW", RMAP_DIMENSION_FLUX, 1e-3, true, true},
    {"kW", RMAP_DIMENSION_FLUX, 1e3, true, true},
    {"MW", RMAP_DIMENSION_FLUX, 1e6, true, false},
    {"lm", RMAP_DIMENSION_FLUX, 1.0, true, true, RMAP_FLUX_LM},
    {"mlm", RMAP_DIMENSION_FLUX, 1e-3, true, true, RMAP_FLUX_LM},
    {"klm", RMAP_DIMENSION_FLUX, 1e3, true, true, RMAP_FLUX_LM},
    {"photons", RMAP_DIMENSION_FLUX, 1.0, true, true, RMAP_FLUX_PHOTONS},
    {"photons/s", RMAP_DIMENSION_FLUX, 1.0, true, false, RMAP_FLUX_PHOTON_RATE},
    {"J", RMAP_DIMENSION_ENERGY, 1.0, true, true, RMAP_FLUX_J},
    {"mJ", RMAP_DIMENSION_ENERGY, 1e-3, true, true, RMAP_FLUX_J},
    {"uJ", RMAP_DIMENSION_ENERGY, 1e-6, true, true, RMAP_FLUX_J},
    {"nJ", RMAP_DIMENSION_ENERGY, 1e-9, true, true, RMAP_FLUX_J},
    {"pJ", RMAP_DIMENSION_ENERGY, 1e-12, true, true, RMAP_FLUX_J},
    {"eV", RMAP_DIMENSION_ENERGY, RMAP_EV_J, true, true, RMAP_FLUX_J},
    {"keV", RMAP_DIMENSION_ENERGY, 1e3 * RMAP_EV_J, true, true, RMAP_FLUX_J},
    {"MeV", RMAP_DIMENSION_ENERGY, 1e6 * RMAP_EV_J, true, true, RMAP_FLUX_J},
    {"GeV", RMAP_DIMENSION_ENERGY, 1e9 * RMAP_EV_J, true, true, RMAP_FLUX_J},
    {"%", RMAP_DIMENSION_SHARE, 1e-2, true, false},
    {"K", RMAP_DIMENSION_TEMPERATURE, 1.0, true, false},
    {"/um", RMAP_DIMENSION_PER_LENGTH, 1e6, true, false},
    {"/mm", RMAP_DIMENSION_PER_LENGTH, 1e3, true, false},
    {"/cm", RMAP_DIMENSION_PER_LENGTH, 1e2, true, false},
    {"/m", RMAP_DIMENSION_PER_LENGTH, 1.0, true, false},
};

const struct rmap_written_unit *rmap_unit_at(size_t i)
{
    return i < sizeof unit_table / sizeof *unit_table ? &unit_table[i] : NULL;
}

const struct rmap_written_unit *rmap_unit_named(const char *name, size_t len)
{
    const struct rmap_written_unit *unit;
    for (size_t i = 0; (unit = rmap_unit_at(i)) != NULL; i++)
        if (strlen(unit->name) == len && memcmp(unit->name, name, len) == 0)
            return unit;
    return NULL;
}

const struct rmap_written_unit *rmap_unit_of_scene(const char *name, enum rmap_dimension dimension)
{
    const struct rmap_written_unit *unit = rmap_unit_named(name, strlen(name));
    return unit && unit->in_scene && unit->dimension == dimension ? unit : NULL;
}

/* Divides by what is above 1, so that 5 mm are the double nearest to 0.005 m. */
double rmap_unit_convert(double value, double from, double to)
{
    double times = from >= to ? from / to : to / from, whole = round(times);
    if (fabs(times - whole) < 1e-12 * whole)
        times = whole;
    return from >= to ? value * times : value / times;
}

size_t rmap_unit_words(enum rmap_dimension dimension, const char *word[RMAP_UNITS_MAX])
{
    const struct rmap_written_unit *unit;
    size_t n = 0;
    for (size_t i = 0; (unit = rmap_unit_at(i)) != NULL; i++)
        if (unit->in_scene && unit->dimension == dimension && n < RMAP_UNITS_MAX)
            word[n++] = unit->name;
    return n;
}
