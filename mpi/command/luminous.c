/* SPDX-License-Identifier: MIT
 *
 * Whether lm are asked for of sources in W.
 */
#include "mpi/command/luminous.h"

#include <string.h>

enum rmap_status rmap_ask_luminous(const struct rmap_scene *scene, const char *quantity,
                                   bool *luminous_ret, struct rmap_error *err)
{
    *luminous_ret =
        quantity && scene->flux_unit == RMAP_FLUX_W && strcmp(quantity, "illuminance") == 0;
    if (quantity && scene->flux_unit > RMAP_FLUX_LM &&
        (strcmp(quantity, "illuminance") == 0 || strcmp(quantity, "luminance") == 0))
        return rmap_error_set(err, RMAP_USAGE,
                              "--quantity %s is of light in W or lm, and this map's is in %s: ask "
                              "for %s",
                              quantity, rmap_flux_unit_name(scene),
                              *quantity == 'i' ? "irradiance" : "radiance");
    for (size_t s = 0; *luminous_ret && s < scene->n_source; s++)
        if (!rmap_source_has_spectrum(&scene->source[s]))
            return rmap_error_set(
                err, RMAP_INPUT,
                "--quantity illuminance: the flux of source '%.60s' is in W, and the scene "
                "does not say its spectrum: give that, or the flux in lm, and "
                "trace anew; or ask for irradiance",
                scene->source[s].name);
    return RMAP_OK;
}
