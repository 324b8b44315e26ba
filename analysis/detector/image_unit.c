/* SPDX-License-Identifier: MIT
 *
 * Units of a detector's values. A foot-candle is a lumen per square foot of 0.3048 m a side.
 */
#include "analysis/detector/image_unit.h"

#include <stdio.h>
#include <string.h>

static const struct rmap_image_unit known[] = {
    {RMAP_PER_AREA, RMAP_FLUX_W, "W/m2", 1.0},
    {RMAP_PER_AREA, RMAP_FLUX_W, "kW/m2", 1e3},
    {RMAP_PER_AREA, RMAP_FLUX_W, "mW/m2", 1e-3},
    {RMAP_PER_AREA, RMAP_FLUX_W, "uW/m2", 1e-6},
    {RMAP_PER_AREA, RMAP_FLUX_W, "W/cm2", 1e4},
    {RMAP_PER_AREA, RMAP_FLUX_W, "mW/cm2", 1e1},
    {RMAP_PER_AREA, RMAP_FLUX_W, "uW/cm2", 1e-2},
    {RMAP_PER_AREA, RMAP_FLUX_W, "W/mm2", 1e6},
    {RMAP_PER_AREA, RMAP_FLUX_W, "mW/mm2", 1e3},
    {RMAP_PER_AREA, RMAP_FLUX_LM, "lx", 1.0},
    {RMAP_PER_AREA, RMAP_FLUX_LM, "klx", 1e3},
    {RMAP_PER_AREA, RMAP_FLUX_LM, "mlx", 1e-3},
    {RMAP_PER_AREA, RMAP_FLUX_LM, "fc", 1.0 / (0.3048 * 0.3048)},
    {RMAP_PER_SOLID_ANGLE, RMAP_FLUX_W, "W/sr", 1.0},
    {RMAP_PER_SOLID_ANGLE, RMAP_FLUX_W, "mW/sr", 1e-3},
    {RMAP_PER_SOLID_ANGLE, RMAP_FLUX_W, "uW/sr", 1e-6},
    {RMAP_PER_SOLID_ANGLE, RMAP_FLUX_LM, "cd", 1.0},
    {RMAP_PER_SOLID_ANGLE, RMAP_FLUX_LM, "kcd", 1e3},
    {RMAP_PER_SOLID_ANGLE, RMAP_FLUX_LM, "mcd", 1e-3},
    {RMAP_PER_AREA_AND_ANGLE, RMAP_FLUX_W, "W/(m2 sr)", 1.0},
    {RMAP_PER_AREA_AND_ANGLE, RMAP_FLUX_W, "W/(cm2 sr)", 1e4},
    {RMAP_PER_AREA_AND_ANGLE, RMAP_FLUX_W, "W/(mm2 sr)", 1e6},
    {RMAP_PER_AREA_AND_ANGLE, RMAP_FLUX_LM, "cd/m2", 1.0},
    {RMAP_PER_AREA_AND_ANGLE, RMAP_FLUX_LM, "kcd/m2", 1e3},
    {RMAP_PER_CELL, RMAP_FLUX_W, "W", 1.0},
    {RMAP_PER_CELL, RMAP_FLUX_W, "mW", 1e-3},
    {RMAP_PER_CELL, RMAP_FLUX_W, "uW", 1e-6},
    {RMAP_PER_CELL, RMAP_FLUX_W, "nW", 1e-9},
    {RMAP_PER_CELL, RMAP_FLUX_LM, "lm", 1.0},
    {RMAP_PER_CELL, RMAP_FLUX_LM, "mlm", 1e-3},
    {RMAP_PER_CELL, RMAP_FLUX_LM, "klm", 1e3},
    {RMAP_PER_AREA, RMAP_FLUX_PHOTONS, "photons/m2", 1.0},
    {RMAP_PER_AREA, RMAP_FLUX_PHOTONS, "photons/cm2", 1e4},
    {RMAP_PER_AREA, RMAP_FLUX_PHOTONS, "photons/mm2", 1e6},
    {RMAP_PER_AREA, RMAP_FLUX_PHOTON_RATE, "photons/(s m2)", 1.0},
    {RMAP_PER_AREA, RMAP_FLUX_PHOTON_RATE, "photons/(s cm2)", 1e4},
    {RMAP_PER_AREA, RMAP_FLUX_PHOTON_RATE, "photons/(s mm2)", 1e6},
    {RMAP_PER_AREA, RMAP_FLUX_J, "J/m2", 1.0},
    {RMAP_PER_AREA, RMAP_FLUX_J, "J/cm2", 1e4},
    {RMAP_PER_AREA, RMAP_FLUX_J, "mJ/cm2", 1e1},
    {RMAP_PER_SOLID_ANGLE, RMAP_FLUX_PHOTONS, "photons/sr", 1.0},
    {RMAP_PER_SOLID_ANGLE, RMAP_FLUX_PHOTON_RATE, "photons/(s sr)", 1.0},
    {RMAP_PER_SOLID_ANGLE, RMAP_FLUX_J, "J/sr", 1.0},
    {RMAP_PER_AREA_AND_ANGLE, RMAP_FLUX_PHOTONS, "photons/(m2 sr)", 1.0},
    {RMAP_PER_AREA_AND_ANGLE, RMAP_FLUX_PHOTON_RATE, "photons/(s m2 sr)", 1.0},
    {RMAP_PER_AREA_AND_ANGLE, RMAP_FLUX_J, "J/(m2 sr)", 1.0},
    {RMAP_PER_CELL, RMAP_FLUX_PHOTONS, "photons", 1.0},
    {RMAP_PER_CELL, RMAP_FLUX_PHOTON_RATE, "photons/s", 1.0},
    {RMAP_PER_CELL, RMAP_FLUX_J, "J", 1.0},
    {RMAP_PER_CELL, RMAP_FLUX_J, "eV", RMAP_EV_J},
    {RMAP_PER_CELL, RMAP_FLUX_J, "MeV", 1e6 * RMAP_EV_J},
};
enum { N_KNOWN = sizeof known / sizeof *known };

static bool fits(const struct rmap_image_unit *unit, enum rmap_detector_quantity quantity,
                 enum rmap_flux_unit flux)
{
    return unit->quantity == quantity && unit->flux == flux;
}

const struct rmap_image_unit *rmap_image_unit_usual(enum rmap_detector_quantity quantity,
                                                    enum rmap_flux_unit flux)
{
    size_t i = 0;
    while (!fits(&known[i], quantity, flux))
        i++;
    return &known[i];
}

enum rmap_status rmap_image_unit_find(enum rmap_detector_quantity quantity,
                                      enum rmap_flux_unit flux, const char *name,
                                      const struct rmap_image_unit **unit_ret,
                                      struct rmap_error *err)
{
    char list[200] = "";
    size_t n = 0;
    *unit_ret = rmap_image_unit_usual(quantity, flux);
    for (size_t i = 0; name && i < N_KNOWN; i++) {
        if (!fits(&known[i], quantity, flux))
            continue;
        if (strcmp(known[i].name, name) == 0) {
            *unit_ret = &known[i];
            return RMAP_OK;
        }
        n += (size_t)snprintf(list + n, sizeof list - n, "%s%s", n > 0 ? ", " : "", known[i].name);
    }
    return name ? rmap_error_set(err, RMAP_USAGE,
                                 "--unit '%.40s' does not fit these values: say one of %s", name,
                                 list)
                : RMAP_OK;
}
