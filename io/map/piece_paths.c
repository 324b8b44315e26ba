/* SPDX-License-Identifier: MIT
 *
 * The rays of a whole piece by the paths of its dictionary.
 */
#include "io/map/piece_paths.h"

#include "base/alloc.h"
#include "compact/paths.h"
#include "io/map/map_internal.h"
#include "io/map/map_paths.h"

enum rmap_status rmap_piece_sums(const struct rmap_map *map, struct rmap_piece_sum **sum_ret,
                                 struct rmap_error *err)
{
    struct rmap_piece_sum *sum = rmap_alloc(map->content.n_piece, sizeof *sum);
    *sum_ret = sum;
    if (!sum)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the pieces of a map");
    for (size_t i = 0; i < map->content.n_portion; i++) {
        const struct rmap_portion_info *info = &map->content.portion[i];
        struct rmap_piece_sum *its = &sum[info->piece];
        for (int t = 0; t < RMAP_TABLE_COUNT; t++)
            its->n_row[t] += info->n_row[t];
        its->n_own += info->stored_rows[RMAP_COMPACT_OWN];
        its->n_own_registration += info->stored_rows[RMAP_COMPACT_OWN_REGISTRATION];
    }
    return RMAP_OK;
}

/* Whether rays of paths and those with paths of their own are all that the map lists. */
static bool add_up(const struct rmap_piece_paths *self, const struct rmap_piece_sum *sum)
{
    const struct rmap_portion *paths = self->paths;
    uint64_t rays = sum->n_own, registrations = sum->n_own_registration;
    for (size_t i = 0; i < paths->n_row[RMAP_TABLE_RAY]; i++) {
        if (self->of[i].rays > sum->n_row[RMAP_TABLE_RAY]) /* no sum is too large */
            return false;
        rays += self->of[i].rays;
        registrations += self->of[i].rays * paths->ray.registration_count[i];
    }
    return rays == sum->n_row[RMAP_TABLE_RAY] &&
           registrations == sum->n_row[RMAP_TABLE_REGISTRATION];
}

enum rmap_status rmap_piece_paths_open(const struct rmap_map *map, size_t piece, bool whole,
                                       const struct rmap_piece_sum *sum,
                                       struct rmap_piece_paths *self, bool *told_ret,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    *self = (struct rmap_piece_paths){.map = map, .piece = piece};
    *told_ret = false;
    if (map->content.piece[piece].encoding != RMAP_ENCODING_COMPACT ||
        sum->n_row[RMAP_TABLE_RAY] == 0)
        goto out;
    RMAP_TRY(rmap_chunk_reader_create(map, &self->reader, err));
    RMAP_TRY(rmap_map_paths(map, piece, whole, self->reader, &self->table, err));
    self->paths = rmap_path_table_rays(self->table);
    if (rmap_map_paths_fit(map, piece))
        RMAP_TRY(rmap_map_path_sums(map, piece, false, &self->of, err));
    *told_ret = self->of && add_up(self, sum);
out:
    if (st != RMAP_OK)
        rmap_piece_paths_fini(self);
    return st;
}

void rmap_piece_paths_fini(struct rmap_piece_paths *self)
{
    if (self->table)
        rmap_map_paths_give_back(self->map, self->piece, self->table);
    rmap_chunk_reader_destroy(self->reader);
    *self = (struct rmap_piece_paths){0};
}
