/* SPDX-License-Identifier: MIT
 *
 * Units of a detector's values. A foot-candle is a lumen per square foot of 0.3048 m a side.
 */
#include "analysis/detector/image_unit.h"

#include <stdio.h>
#include <string.h>

static const struct rmap_image_unit known[] = {
    {RMAP_PER_AREA, false, "W/m2", 1.0},
    {RMAP_PER_AREA, false, "kW/m2", 1e3},
    {RMAP_PER_AREA, false, "mW/m2", 1e-3},
    {RMAP_PER_AREA, false, "uW/m2", 1e-6},
    {RMAP_PER_AREA, false, "W/cm2", 1e4},
    {RMAP_PER_AREA, false, "mW/cm2", 1e1},
    {RMAP_PER_AREA, false, "uW/cm2", 1e-2},
    {RMAP_PER_AREA, false, "W/mm2", 1e6},
    {RMAP_PER_AREA, false, "mW/mm2", 1e3},
    {RMAP_PER_AREA, true, "lx", 1.0},
    {RMAP_PER_AREA, true, "klx", 1e3},
    {RMAP_PER_AREA, true, "mlx", 1e-3},
    {RMAP_PER_AREA, true, "fc", 1.0 / (0.3048 * 0.3048)},
    {RMAP_PER_SOLID_ANGLE, false, "W/sr", 1.0},
    {RMAP_PER_SOLID_ANGLE, false, "mW/sr", 1e-3},
    {RMAP_PER_SOLID_ANGLE, false, "uW/sr", 1e-6},
    {RMAP_PER_SOLID_ANGLE, true, "cd", 1.0},
    {RMAP_PER_SOLID_ANGLE, true, "kcd", 1e3},
    {RMAP_PER_SOLID_ANGLE, true, "mcd", 1e-3},
    {RMAP_PER_AREA_AND_ANGLE, false, "W/(m2 sr)", 1.0},
    {RMAP_PER_AREA_AND_ANGLE, false, "W/(cm2 sr)", 1e4},
    {RMAP_PER_AREA_AND_ANGLE, false, "W/(mm2 sr)", 1e6},
    {RMAP_PER_AREA_AND_ANGLE, true, "cd/m2", 1.0},
    {RMAP_PER_AREA_AND_ANGLE, true, "kcd/m2", 1e3},
    {RMAP_PER_CELL, false, "W", 1.0},
    {RMAP_PER_CELL, false, "mW", 1e-3},
    {RMAP_PER_CELL, false, "uW", 1e-6},
    {RMAP_PER_CELL, false, "nW", 1e-9},
    {RMAP_PER_CELL, true, "lm", 1.0},
    {RMAP_PER_CELL, true, "mlm", 1e-3},
    {RMAP_PER_CELL, true, "klm", 1e3},
};
enum { N_KNOWN = sizeof known / sizeof *known };

static bool fits(const struct rmap_image_unit *unit, enum rmap_detector_quantity quantity,
                 bool lumens)
{
    return unit->quantity == quantity && unit->lumens == lumens;
}

const struct rmap_image_unit *rmap_image_unit_usual(enum rmap_detector_quantity quantity,
                                                    bool lumens)
{
    size_t i = 0;
    while (!fits(&known[i], quantity, lumens))
        i++;
    return &known[i];
}

enum rmap_status rmap_image_unit_find(enum rmap_detector_quantity quantity, bool lumens,
                                      const char *name, const struct rmap_image_unit **unit_ret,
                                      struct rmap_error *err)
{
    char list[200] = "";
    size_t n = 0;
    *unit_ret = rmap_image_unit_usual(quantity, lumens);
    for (size_t i = 0; name && i < N_KNOWN; i++) {
        if (!fits(&known[i], quantity, lumens))
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
