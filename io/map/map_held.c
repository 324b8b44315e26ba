/* SPDX-License-Identifier: MIT
 *
 * A map whose portions stand in memory as they were traced. Each rank's are one piece, plain, since
 * their columns stand as they are.
 */
#include "io/map/map_held.h"

#include <string.h>

#include "base/alloc.h"
#include "io/map/map_internal.h"
#include "trace/tally.h"

void rmap_held_fini(struct rmap_held *held)
{
    for (size_t i = 0; held->portion && i < held->n; i++)
        rmap_portion_destroy(held->portion[i]);
    rmap_free(held->portion);
    rmap_free(held->info);
    *held = (struct rmap_held){.n = 0};
}

void rmap_held_describe(const struct rmap_portion *portion, int rank,
                        struct rmap_portion_info *info)
{
    *info =
        (struct rmap_portion_info){.shard = rank, .piece = rank, .first_ray = portion->first_ray};
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        info->n_row[t] = portion->n_row[t];
    info->last_ray = info->first_ray + info->n_row[RMAP_TABLE_RAY] - 1;
    rmap_portion_summarise(portion, &info->summary);
}

static void list_pieces(struct rmap_map *map, const struct rmap_held *held)
{
    struct rmap_map_content *content = &map->content;
    content->n_piece = content->cap_piece = (size_t)held->n_rank;
    for (int r = 0; r < held->n_rank; r++)
        content->piece[r] =
            (struct rmap_piece_info){.shard = r, .name = "memory", .encoding = RMAP_ENCODING_PLAIN};
    for (size_t i = 0; i < held->n; i++)
        for (int t = 0; t < RMAP_TABLE_COUNT; t++) {
            content->piece[held->info[i].piece].n_row[t] += held->info[i].n_row[t];
            content->n_row[t] += held->info[i].n_row[t];
        }
}

/* Memory for all that is needed, so that nothing fails once things change hands. */
static enum rmap_status make(const struct rmap_held *held, const struct rmap_scene *scene,
                             struct rmap_map **map_ret, struct rmap_error *err)
{
    struct rmap_map *map = rmap_alloc(1, sizeof *map);
    if (!map)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the rays");
    (void)pthread_mutex_init(&map->lock, NULL);
    (void)pthread_mutex_init(&map->paths_lock, NULL);
    (void)pthread_mutex_init(&map->hdf5_lock, NULL);
    map->path = rmap_strdup("memory");
    map->scene = rmap_alloc(1, sizeof *map->scene);
    map->model = rmap_alloc(1, sizeof *map->model);
    map->spaces.space = rmap_alloc(1, sizeof *map->spaces.space);
    map->flux_per_weight = rmap_alloc(scene->n_source + 1, sizeof *map->flux_per_weight);
    map->content.piece = rmap_alloc((size_t)held->n_rank, sizeof *map->content.piece);
    *map_ret = map;
    if (!map->path || !map->scene || !map->model || !map->spaces.space || !map->flux_per_weight ||
        !map->content.piece)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the rays");
    return RMAP_OK;
}

enum rmap_status rmap_map_hold(struct rmap_held *held, struct rmap_scene *scene,
                               struct rmap_tally *tally, struct rmap_map **map_ret,
                               struct rmap_error *err)
{
    struct rmap_map *map = NULL;
    enum rmap_status st = make(held, scene, &map, err);
    RMAP_TRY(st);
    list_pieces(map, held);
    map->content.portion = held->info;
    map->content.n_portion = map->content.cap_portion = held->n;
    st = rmap_map_sum_up(map, err);
    if (st != RMAP_OK) {
        map->content.portion = NULL;
        map->content.n_portion = 0;
        goto out;
    }
    map->held = held->portion;
    *held = (struct rmap_held){.n_rank = held->n_rank, .seed = held->seed};
    map->scene[0] = scene;
    map->spaces.n = map->spaces.cap = 1;
    map->spaces.space[0].mode = (int32_t)scene->channels.mode;
    map->spaces.space[0].n_channel = map->n_channel_max = scene->channels.n;
    map->summary.complete = true;
    map->summary.n_rank = held->n_rank;
    map->summary.seed = held->seed;
    map->tally = tally;
    rmap_map_derive_flux(map);
    *map_ret = map;
    map = NULL;
out:
    rmap_map_close(map);
    return st;
}

bool rmap_map_is_held(const struct rmap_map *map)
{
    return map->held != NULL;
}
