/* SPDX-License-Identifier: MIT
 *
 * Sources dimmed after the trace.
 */
#include "io/map/map_dim.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "io/map/map_internal.h"

static size_t n_source(const struct rmap_map *map)
{
    return map->scene[0]->n_source;
}

enum rmap_status rmap_map_dim(struct rmap_map *map, double maintenance, const double *factor,
                              struct rmap_error *err)
{
    rmap_free(map->dim);
    map->dim = rmap_alloc(n_source(map) + 1, sizeof *map->dim);
    if (!map->dim)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu sources", n_source(map));
    memcpy(map->dim, factor, n_source(map) * sizeof *factor);
    map->maintenance = maintenance;
    rmap_map_derive_flux(map);
    return RMAP_OK;
}

void rmap_map_undim(struct rmap_map *map)
{
    if (!map->dim)
        return;
    rmap_free(map->dim);
    map->dim = NULL;
    rmap_map_derive_flux(map);
}

double rmap_map_dimmed(const struct rmap_map *map, size_t source)
{
    return map->dim ? map->maintenance * map->dim[source] : 1.0;
}

static bool is_dimmed(const struct rmap_map *map, size_t source)
{
    return map->dim[source] < 1.0 || map->dim[source] > 1.0;
}

/* Sources that are dimmed, or those that are put out; behind what is told already. */
static size_t list_sources(const struct rmap_map *map, bool out, char text[RMAP_MAP_DIM_LEN],
                           size_t len)
{
    size_t n = 0;
    for (size_t s = 0; s < n_source(map) && len < RMAP_MAP_DIM_LEN; s++) {
        char *to = text + len;
        const size_t room = RMAP_MAP_DIM_LEN - len;
        const char *before = n > 0 ? ", " : len > 0 ? "; " : "";
        const char *name = map->scene[0]->source[s].name;
        if (!is_dimmed(map, s) || out == (map->dim[s] > 0.0))
            continue;
        len += (size_t)(out ? snprintf(to, room, "%s%s%.40s", before, n ? "" : "without ", name)
                            : snprintf(to, room, "%s%.40s x %.6g", before, name, map->dim[s]));
        n++;
    }
    return len;
}

void rmap_map_dim_text(const struct rmap_map *map, char text[RMAP_MAP_DIM_LEN])
{
    size_t len = 0;
    text[0] = 0;
    if (!map->dim)
        return;
    if (map->maintenance < 1.0)
        len = (size_t)snprintf(text, RMAP_MAP_DIM_LEN, "maintenance factor %.6g", map->maintenance);
    len = list_sources(map, false, text, len);
    (void)list_sources(map, true, text, len);
}

void rmap_json_add_dim(json_t *document, const struct rmap_map *map)
{
    if (!document || !map->dim)
        return;
    json_t *dim = json_object();
    for (size_t s = 0; s < n_source(map); s++)
        if (is_dimmed(map, s))
            (void)json_object_set_new(dim, map->scene[0]->source[s].name, json_real(map->dim[s]));
    (void)json_object_set_new(document, "maintenance", json_real(map->maintenance));
    (void)json_object_set_new(document, "dim", dim);
}
