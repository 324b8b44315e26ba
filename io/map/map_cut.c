/* SPDX-License-Identifier: MIT
 *
 * A map asked as if only its first portions had been traced.
 */
#include "io/map/map_cut.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/grouped.h"
#include "io/map/map_internal.h"
#include "trace/tally.h"

void rmap_map_part_text(const struct rmap_map_part *part, char text[RMAP_MAP_PART_LEN])
{
    char first[RMAP_GROUPED_LEN], second[RMAP_GROUPED_LEN];
    text[0] = 0;
    if (part && part->relative > 0.0)
        (void)snprintf(text, RMAP_MAP_PART_LEN, "%.3g %% %s, by the first %s of %s rays",
                       100.0 * part->relative, part->is_reached ? "reached" : "NOT reached",
                       rmap_grouped(part->n_ray, first), rmap_grouped(part->all_rays, second));
}

/* A round of so few rows hides among the first rays. */
enum { FEW_ROWS = 512 };

static bool is_in_order(const struct rmap_map *map)
{
    const struct rmap_scene *scene = map->scene[0];
    bool ordered = rmap_map_n_space(map) > 1;
    for (size_t s = 0; s < scene->n_source; s++) {
        const struct rmap_source *source = &scene->source[s];
        ordered |= source->type == RMAP_SOURCE_STEPS || source->n_list > FEW_ROWS ||
                   (source->rays && source->rays->n > FEW_ROWS);
    }
    return ordered;
}

enum rmap_status rmap_map_cut_init(struct rmap_map_cut *cut, struct rmap_map *map,
                                   struct rmap_error *err)
{
    const size_t n_source = map->scene[0]->n_source;
    *cut = (struct rmap_map_cut){
        .map = map, .n_portion = map->content.n_portion, .is_in_order = is_in_order(map)};
    memcpy(cut->n_row, map->content.n_row, sizeof cut->n_row);
    if (map->selection)
        return rmap_error_set(err, RMAP_USAGE,
                              "%s holds rays that a query picked: the first of them are no sample "
                              "of what was traced",
                              map->path);
    cut->emitted = rmap_alloc(n_source + 1, sizeof *cut->emitted);
    if (!cut->emitted)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a part of a map");
    memcpy(cut->emitted, map->tally->emitted, n_source * sizeof *cut->emitted);
    return RMAP_OK;
}

/* Rays of each source among the ids [first, first + n). */
static void add_emitted(const struct rmap_scene *scene, uint64_t first, uint64_t n, double *emitted)
{
    const uint64_t period = scene->schedule_len;
    if (period == 0)
        return;
    for (size_t s = 0; s < scene->n_source; s++)
        emitted[s] += (double)(n / period * scene->schedule_quota[s]);
    for (uint64_t k = 0; k < n % period; k++)
        emitted[scene->schedule[(first + k) % period]] += 1.0;
}

void rmap_map_cut_to(struct rmap_map_cut *cut, size_t n_portion)
{
    struct rmap_map *map = cut->map;
    double *emitted = map->tally->emitted;
    const size_t n_source = map->scene[0]->n_source;
    map->content.n_portion = n_portion;
    if (n_portion == cut->n_portion) {
        memcpy(emitted, cut->emitted, n_source * sizeof *emitted);
        memcpy(map->content.n_row, cut->n_row, sizeof cut->n_row);
    } else {
        memset(emitted, 0, n_source * sizeof *emitted);
        memset(map->content.n_row, 0, sizeof map->content.n_row);
        for (size_t i = 0; i < n_portion; i++) {
            const struct rmap_portion_info *info = &map->content.portion[i];
            add_emitted(map->scene[0], info->first_ray, info->n_row[RMAP_TABLE_RAY], emitted);
            for (int t = 0; t < RMAP_TABLE_COUNT; t++)
                map->content.n_row[t] += info->n_row[t];
        }
    }
    rmap_map_derive_flux(map);
}

void rmap_map_cut_fini(struct rmap_map_cut *cut)
{
    if (cut->emitted)
        rmap_map_cut_to(cut, cut->n_portion);
    rmap_free(cut->emitted);
    *cut = (struct rmap_map_cut){0};
}
