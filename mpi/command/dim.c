/* SPDX-License-Identifier: MIT
 *
 * --dim and --maintenance: sources dimmed after the trace.
 */
#include "mpi/command/dim.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/glob.h"
#include "io/file/diagnostics.h"
#include "mpi/command/argument_numbers.h"
#include "scene/sky.h"

static enum rmap_status refuse_name(const struct rmap_scene *scene, const char *name,
                                    struct rmap_error *err)
{
    const char **known = rmap_alloc(scene->n_source + 1, sizeof *known);
    if (!known)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the sources' names");
    for (size_t s = 0; s < scene->n_source; s++)
        known[s] = scene->source[s].name;
    const char *nearest = rmap_nearest_word(name, known, scene->n_source);
    const char *first = scene->n_source > 0 ? known[0] : "none";
    const enum rmap_status st =
        nearest ? rmap_error_set(err, RMAP_INPUT,
                                 "--dim: no source named '%.60s' in this map (did you mean "
                                 "'%.60s'?)",
                                 name, nearest)
                : rmap_error_set(err, RMAP_INPUT,
                                 "--dim: no source named '%.60s' in this map; it has '%.60s' and "
                                 "what raymap info lists",
                                 name, first);
    rmap_free(known);
    return st;
}

/* "lamp=0.5"; what is said later of a source holds. */
static enum rmap_status read_one(const struct rmap_scene *scene, char *text, double *factor,
                                 struct rmap_error *err)
{
    char *value = strrchr(text, '='), *end = NULL;
    const double times = value ? strtod(value + 1, &end) : 0.0;
    bool found = false;
    if (!value || end == value + 1 || *end || !(times >= 0.0) || times > 1e6)
        return rmap_error_set(err, RMAP_USAGE,
                              "--dim '%.60s': say of a source how many times its flux, as lamp=0.5",
                              text);
    *value = 0;
    for (size_t s = 0; s < scene->n_source; s++)
        if (rmap_glob(text, scene->source[s].name)) {
            factor[s] = times;
            found = true;
        }
    return found ? RMAP_OK : refuse_name(scene, text, err);
}

enum rmap_status rmap_dim_read(const struct rmap_arguments *given, struct rmap_map *map,
                               struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = rmap_map_scene(map);
    double maintenance = 1.0, *factor = NULL;
    char **list = NULL;
    size_t n = 0;
    RMAP_TRY(rmap_argument_number(given, "maintenance", &maintenance, err));
    if (!(maintenance > 0.0 && maintenance <= 1.0))
        return rmap_error_set(err, RMAP_USAGE,
                              "--maintenance %g: what is left of the flux, above 0 and up to 1",
                              maintenance);
    RMAP_TRY(rmap_argument_list(given, "dim", &list, &n, err));
    if (n == 0 && !rmap_argument(given, "maintenance"))
        return RMAP_OK;
    factor = rmap_alloc(scene->n_source + 1, sizeof *factor);
    if (!factor)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu sources", scene->n_source);
    for (size_t s = 0; factor && s < scene->n_source; s++)
        factor[s] = 1.0;
    for (size_t i = 0; i < n && st == RMAP_OK; i++)
        st = read_one(scene, list[i], factor, err);
    if (st == RMAP_OK)
        st = rmap_map_dim(map, maintenance, factor, err);
out:
    rmap_argument_list_free(list, n);
    rmap_free(factor);
    return st;
}

enum rmap_status rmap_dim_to_daylight(struct rmap_map *map, double *horizontal_ret,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = rmap_map_scene(map);
    double *factor = rmap_alloc(scene->n_source + 1, sizeof *factor), horizontal = 0.0;
    if (!factor)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu sources", scene->n_source);
    for (size_t s = 0; s < scene->n_source; s++) {
        if (scene->source[s].type != RMAP_SOURCE_SKY)
            continue;
        factor[s] = rmap_map_dimmed(map, s);
        horizontal += rmap_sky_irradiance(scene->source[s].sky);
    }
    if (!(horizontal > 0.0))
        st = rmap_error_set(err, RMAP_INPUT,
                            "daylight factor: this map has no light of a sky: the scene needs a "
                            "source as {name: sky, type: sky, kind: 1, horizontal: 10 klx}");
    else if (scene->flux_unit != RMAP_FLUX_LM)
        st = rmap_error_set(err, RMAP_INPUT,
                            "daylight factor: the sources are in %s, and it is of illuminances: "
                            "give the sky in lx or cd/m2, and trace anew",
                            rmap_flux_unit_name(scene));
    else
        st = rmap_map_dim(map, 1.0, factor, err);
    *horizontal_ret = horizontal;
    rmap_free(factor);
    return st;
}

void rmap_dim_print(const struct rmap_map *map)
{
    char text[RMAP_MAP_DIM_LEN];
    rmap_map_dim_text(map, text);
    if (text[0])
        printf("%-14s %s\n", "dimmed", text);
}
