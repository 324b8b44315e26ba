/* SPDX-License-Identifier: MIT
 *
 * What an open map tells of itself.
 */
#include "io/map/map_internal.h"

#include <string.h>

#include "trace/tally.h"

uint64_t rmap_portion_end(const struct rmap_portion_info *portion)
{
    uint64_t n = portion->n_row[RMAP_TABLE_RAY];
    if (portion->last_ray >= portion->first_ray && portion->last_ray - portion->first_ray >= n)
        return portion->last_ray == UINT64_MAX ? UINT64_MAX : portion->last_ray + 1;
    return n > UINT64_MAX - portion->first_ray ? UINT64_MAX : portion->first_ray + n;
}

bool rmap_portion_has_gaps(const struct rmap_portion_info *portion)
{
    return rmap_portion_end(portion) - portion->first_ray > portion->n_row[RMAP_TABLE_RAY];
}

const struct rmap_scene *rmap_map_scene(const struct rmap_map *map)
{
    return map->scene[0];
}

size_t rmap_map_n_space(const struct rmap_map *map)
{
    return map->spaces.n;
}

const struct rmap_scene *rmap_map_scene_of(const struct rmap_map *map, size_t space)
{
    return map->scene[space];
}

bool rmap_map_find_ray(const struct rmap_map *map, uint64_t ray, size_t *portion)
{
    const struct rmap_portion_info *info = map->content.portion;
    size_t low = 0, high = *portion;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (info[middle].first_ray <= ray)
            low = middle + 1;
        else
            high = middle;
    }
    while (low > 0 && map->reach[low] > ray)
        if (rmap_portion_end(&info[--low]) > ray) {
            *portion = low;
            return true;
        }
    return false;
}

size_t rmap_map_space_of_ray(const struct rmap_map *map, uint64_t ray)
{
    size_t portion = map->content.n_portion;
    if (map->spaces.n < 2 || !rmap_map_find_ray(map, ray, &portion))
        return 0;
    return (size_t)map->content.portion[portion].space;
}

int rmap_map_n_channel(const struct rmap_map *map)
{
    return map->n_channel_max;
}

size_t rmap_map_n_run(const struct rmap_map *map)
{
    return map->n_run;
}

const struct rmap_run_row *rmap_map_run(const struct rmap_map *map, size_t run)
{
    return &map->run[run];
}

size_t rmap_map_n_run_after(const struct rmap_map *map, const struct rmap_map *later)
{
    if (strcmp(map->scene_digest, later->scene_digest) != 0 || later->n_run < map->n_run)
        return 0;
    for (size_t i = 0; i < map->n_run; i++) {
        const struct rmap_run_row *a = &map->run[i], *b = &later->run[i];
        if (a->first_ray != b->first_ray || a->n_ray != b->n_ray || a->seed != b->seed ||
            a->space != b->space)
            return 0;
    }
    return later->n_run - map->n_run;
}

const struct rmap_map_content *rmap_map_contents(const struct rmap_map *map)
{
    return &map->content;
}

size_t rmap_map_n_trouble(const struct rmap_map *map)
{
    return map->n_trouble;
}

const char *rmap_map_trouble(const struct rmap_map *map, size_t i)
{
    return map->trouble[i];
}

const struct rmap_bundle *rmap_map_bundle(const struct rmap_map *map)
{
    return map->bundle;
}

const struct rmap_tally *rmap_map_tally(const struct rmap_map *map)
{
    return map->tally;
}

const struct rmap_selection *rmap_map_selection(const struct rmap_map *map)
{
    return map->selection;
}

const double *rmap_map_emitted(const struct rmap_map *map)
{
    return map->selection ? map->selection->emitted : map->tally->emitted;
}

size_t rmap_map_n_portion(const struct rmap_map *map)
{
    return map->content.n_portion;
}

const struct rmap_portion_info *rmap_map_portion(const struct rmap_map *map, size_t portion)
{
    return &map->content.portion[portion];
}

size_t rmap_map_n_piece(const struct rmap_map *map)
{
    return map->content.n_piece;
}

const struct rmap_piece_info *rmap_map_piece(const struct rmap_map *map, size_t piece)
{
    return &map->content.piece[piece];
}

void rmap_map_summarise(const struct rmap_map *map, struct rmap_map_summary *summary)
{
    *summary = map->summary;
}

const double *rmap_map_flux_per_weight(const struct rmap_map *map)
{
    return map->flux_per_weight;
}

double rmap_map_flux(const struct rmap_map *map, size_t source, double weight)
{
    const double n = rmap_map_emitted(map)[source];
    return n > 0.0 && weight == n ? rmap_map_scene(map)->source[source].flux
                                  : map->flux_per_weight[source] * weight;
}

size_t rmap_map_split(const struct rmap_map *map, size_t n_part, size_t part)
{
    size_t low = 0, high = map->content.n_portion;
    if (part >= n_part)
        return high;
    /* work x part / n_part without overflow; a part's share may be off by n_part. */
    uint64_t total = map->work[high];
    uint64_t want = total / n_part * part + total % n_part * part / n_part;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (map->work[middle] < want)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}
