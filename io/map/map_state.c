/* SPDX-License-Identifier: MIT
 *
 * The state in which a process has a map open, for other processes of the same program.
 */
#include "io/map/map_state.h"

#include <string.h>

#include "base/alloc.h"
#include "io/map/map_internal.h"
#include "trace/tally.h"

/* Between ranks of one program: behind it the tally's values, then the content. */
struct head {
    char scene_digest[40];
    uint64_t seed, index_nbytes, n_value, first_error_ray;
    int32_t complete, n_rank;
};

static struct head head_of(const struct rmap_map *map)
{
    struct head head = {.seed = map->summary.seed,
                        .index_nbytes = map->index_nbytes,
                        .n_value = map->tally->n_value,
                        .first_error_ray = map->tally->first_error_ray,
                        .complete = map->summary.complete,
                        .n_rank = map->summary.n_rank};
    memcpy(head.scene_digest, map->scene_digest, sizeof map->scene_digest);
    return head;
}

enum rmap_status rmap_map_state_pack(const struct rmap_map *map, uint8_t **blob_ret,
                                     size_t *nbytes_ret, struct rmap_error *err)
{
    const struct head head = head_of(map);
    const size_t values = map->tally->n_value * sizeof *map->tally->value;
    uint8_t *content = NULL, *blob = NULL;
    size_t n_content = 0;
    enum rmap_status st = rmap_map_content_pack(&map->content, &content, &n_content, err);
    if (st != RMAP_OK)
        return st;
    blob = rmap_alloc(sizeof head + values + n_content, 1);
    if (blob) {
        memcpy(blob, &head, sizeof head);
        memcpy(blob + sizeof head, map->tally->value, values);
        memcpy(blob + sizeof head + values, content, n_content);
        *blob_ret = blob;
        *nbytes_ret = sizeof head + values + n_content;
    } else {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the state of a map");
    }
    rmap_free(content);
    return st;
}

/* Whether the index that this process read is that of the map which was packed. */
static bool is_of(const struct rmap_map *map, const struct head *head, size_t nbytes)
{
    return head->seed == map->summary.seed && head->n_value == map->tally->n_value &&
           memcmp(head->scene_digest, map->scene_digest, sizeof map->scene_digest) == 0 &&
           nbytes - sizeof *head >= head->n_value * sizeof *map->tally->value;
}

static bool has_its_spaces(const struct rmap_map *map)
{
    bool good = true;
    for (size_t i = 0; i < map->content.n_piece; i++)
        good = good && map->content.piece[i].space >= 0 &&
               (size_t)map->content.piece[i].space < map->spaces.n;
    return good;
}

static enum rmap_status replaced(const struct rmap_map *map, struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_SYSTEM, "%s was replaced while it was opened: ask again",
                          map->path);
}

enum rmap_status rmap_map_state_take(struct rmap_map *map, const uint8_t *blob, size_t nbytes,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map_content content = {0};
    struct head head = {0};
    if (nbytes >= sizeof head)
        memcpy(&head, blob, sizeof head);
    if (nbytes < sizeof head || !is_of(map, &head, nbytes))
        return replaced(map, err);
    const size_t values = map->tally->n_value * sizeof *map->tally->value;
    RMAP_TRY(rmap_map_content_unpack(blob + sizeof head + values, nbytes - sizeof head - values,
                                     &content, err));
    rmap_map_forget(map);
    rmap_map_content_fini(&map->content);
    map->content = content;
    memcpy(map->tally->value, blob + sizeof head, values);
    map->tally->first_error_ray = head.first_error_ray;
    map->index_nbytes = head.index_nbytes;
    map->summary.complete = head.complete != 0;
    map->summary.n_rank = head.n_rank;
    if (!has_its_spaces(map)) {
        map->content.n_piece = 0;
        return replaced(map, err);
    }
    RMAP_TRY(rmap_map_content_sort(&map->content, err));
    RMAP_TRY(rmap_map_content_check(&map->content, map->path, err));
    rmap_map_derive_flux(map);
    RMAP_TRY(rmap_map_sum_up(map, err));
out:
    return st;
}
