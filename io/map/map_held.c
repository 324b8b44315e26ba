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

static void list_rows(struct rmap_map_content *content, const struct rmap_portion_info *info)
{
    for (int t = 0; t < RMAP_TABLE_COUNT; t++) {
        content->piece[info->piece].n_row[t] += info->n_row[t];
        content->n_row[t] += info->n_row[t];
    }
    rmap_digest_add(&content->digest, info->digest);
}

/* Memory for all that is needed, so that nothing fails once things change hands. */
static enum rmap_status make(int n_rank, const struct rmap_scene *scene, struct rmap_map **map_ret,
                             struct rmap_error *err)
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
    map->held = rmap_alloc(1, sizeof(void *));
    map->held_elsewhere = rmap_alloc(1, sizeof *map->held_elsewhere);
    map->spaces.space = rmap_alloc(1, sizeof *map->spaces.space);
    map->flux_per_weight = rmap_alloc(scene->n_source + 1, sizeof *map->flux_per_weight);
    map->content.piece = rmap_alloc((size_t)n_rank, sizeof *map->content.piece);
    *map_ret = map;
    if (!map->path || !map->scene || !map->model || !map->held || !map->held_elsewhere ||
        !map->spaces.space || !map->flux_per_weight || !map->content.piece)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the rays");
    return RMAP_OK;
}

enum rmap_status rmap_map_hold(int n_rank, uint64_t seed, struct rmap_scene *scene,
                               struct rmap_map **map_ret, struct rmap_error *err)
{
    struct rmap_map *map = NULL;
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(make(n_rank, scene, &map, err));
    map->content.n_piece = map->content.cap_piece = (size_t)n_rank;
    for (int r = 0; r < n_rank; r++)
        map->content.piece[r] =
            (struct rmap_piece_info){.shard = r, .name = "memory", .encoding = RMAP_ENCODING_PLAIN};
    RMAP_TRY(rmap_map_sum_up(map, err));
    RMAP_TRY(rmap_tally_create(scene, &map->tally, err));
    map->scene[0] = scene;
    map->spaces.n = map->spaces.cap = 1;
    map->spaces.space[0].mode = (int32_t)scene->channels.mode;
    map->spaces.space[0].n_channel = map->n_channel_max = scene->channels.n;
    map->summary.complete = true;
    map->summary.n_rank = n_rank;
    map->summary.seed = seed;
    rmap_map_derive_flux(map);
    *map_ret = map;
    map = NULL;
out:
    rmap_map_close(map);
    return st;
}

size_t rmap_held_nbytes(const struct rmap_portion *portion)
{
    size_t nbytes = 0;
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (rmap_portion_column(portion, (enum rmap_column)c))
            nbytes += rmap_portion_row_nbytes(portion, (enum rmap_column)c) *
                      portion->cap[rmap_column_info((enum rmap_column)c)->table];
    return nbytes;
}

size_t rmap_map_held_nbytes(const struct rmap_map *map)
{
    return map->held_nbytes;
}

/* Behind those that are there. */
static enum rmap_status append(struct rmap_map *map, const struct rmap_held *more,
                               struct rmap_error *err)
{
    struct rmap_map_content *content = &map->content;
    const size_t n = content->n_portion + more->n;
    struct rmap_portion **held = rmap_realloc(map->held, n + 1, sizeof(void *));
    if (held)
        map->held = held;
    struct rmap_portion_info *info =
        held ? rmap_realloc(content->portion, n + 1, sizeof *content->portion) : NULL;
    if (!info)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the rays");
    content->portion = info;
    content->cap_portion = n + 1;
    for (size_t i = 0; i < more->n; i++) {
        held[content->n_portion + i] = more->portion[i];
        info[content->n_portion + i] = more->info[i];
    }
    content->n_portion = n;
    rmap_map_content_run_up(content, n - more->n);
    return RMAP_OK;
}

enum rmap_status rmap_map_hold_more(struct rmap_map *map, struct rmap_held *more,
                                    const struct rmap_tally *tally, struct rmap_error *err)
{
    struct rmap_map_content *content = &map->content;
    const size_t n_before = content->n_portion;
    enum rmap_status st = append(map, more, err);
    if (st != RMAP_OK)
        return st;
    for (size_t i = 0; i < more->n; i++)
        list_rows(content, &more->info[i]);
    st = rmap_map_sum_up(map, err);
    if (st != RMAP_OK) {
        content->n_portion = n_before;
        return st;
    }
    for (size_t i = 0; i < more->n; i++)
        map->held_nbytes += more->portion[i] ? rmap_held_nbytes(more->portion[i]) : 0;
    rmap_free(more->portion); /* the list; what is in it is the map's */
    rmap_free(more->info);
    *more = (struct rmap_held){.n_rank = more->n_rank, .seed = more->seed};
    rmap_tally_merge(map->tally, tally);
    rmap_map_derive_flux(map);
    return RMAP_OK;
}

bool rmap_map_is_held(const struct rmap_map *map)
{
    return map->held != NULL;
}

void rmap_map_set_elsewhere(const struct rmap_map *map, struct rmap_held_elsewhere elsewhere)
{
    *map->held_elsewhere = elsewhere;
}

enum rmap_status rmap_map_held_portion(const struct rmap_map *map, size_t portion,
                                       const struct rmap_portion **portion_ret,
                                       struct rmap_error *err)
{
    const struct rmap_held_elsewhere *elsewhere = map->held_elsewhere;
    *portion_ret = map->held[portion];
    if (*portion_ret)
        return RMAP_OK;
    if (!elsewhere->fetch)
        return rmap_error_set(err, RMAP_INTERNAL, "rays that another rank has are read");
    return elsewhere->fetch(elsewhere->context, portion, portion_ret, err);
}
