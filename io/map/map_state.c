/* SPDX-License-Identifier: MIT
 *
 * The state in which a process has a map open, for other processes of the same program.
 */
#include "io/map/map_state.h"

#include <errno.h>
#include <string.h>
#include <sys/mman.h>

#include "base/alloc.h"
#include "io/file/shared_memory.h"
#include "io/map/map_internal.h"
#include "trace/tally.h"

/* Between ranks of one program: behind it the tally's values, then the content. */
struct head {
    char scene_digest[40];
    uint64_t seed, index_nbytes, n_value, first_error_ray;
    int32_t complete, n_rank;
    uint64_t n_row[RMAP_TABLE_COUNT];
    struct rmap_digest digest;
};

static struct head head_of(const struct rmap_map *map)
{
    struct head head = {.seed = map->summary.seed,
                        .index_nbytes = map->index_nbytes,
                        .n_value = map->tally->n_value,
                        .first_error_ray = map->tally->first_error_ray,
                        .complete = map->summary.complete,
                        .n_rank = map->summary.n_rank,
                        .digest = map->content.digest};
    memcpy(head.n_row, map->content.n_row, sizeof head.n_row);
    memcpy(head.scene_digest, map->scene_digest, sizeof map->scene_digest);
    return head;
}

static void pack(const struct rmap_map *map, struct rmap_packing *packing)
{
    const struct head head = head_of(map);
    rmap_pack(packing, &head, sizeof head);
    rmap_pack(packing, map->tally->value, map->tally->n_value * sizeof *map->tally->value);
    rmap_map_content_pack(&map->content, packing);
}

enum rmap_status rmap_map_state_pack(const struct rmap_map *map, uint8_t **blob_ret,
                                     size_t *nbytes_ret, struct rmap_error *err)
{
    const size_t nbytes = sizeof(struct head) + map->tally->n_value * sizeof *map->tally->value +
                          rmap_map_content_packed_nbytes(&map->content);
    uint8_t *blob = rmap_alloc_unset(nbytes, 1);
    if (!blob)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the state of a map");
    pack(map, &(struct rmap_packing){.to = blob});
    *blob_ret = blob;
    *nbytes_ret = nbytes;
    return RMAP_OK;
}

/* Written, not mapped and filled: that would touch each page by a fault of its own. */
enum rmap_status rmap_map_state_share(const struct rmap_map *map, int fd, struct rmap_error *err)
{
    struct rmap_packing packing = {.fd = fd};
    pack(map, &packing);
    return packing.failed ? rmap_error_set(err, RMAP_SYSTEM, "cannot share the state of a map: %s",
                                           strerror(errno))
                          : RMAP_OK;
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

/* mapped: the map's rows, already sorted and checked, stay in the blob, which becomes the map's. */
static enum rmap_status take(struct rmap_map *map, uint8_t *blob, size_t nbytes, bool mapped,
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
    uint8_t *rows = blob + sizeof head + values;
    RMAP_TRY(mapped ? rmap_map_content_view(rows, nbytes - sizeof head - values, &content, err)
                    : rmap_map_content_unpack(rows, nbytes - sizeof head - values, &content, err));
    content.mapped = mapped ? blob : NULL;
    content.mapped_nbytes = nbytes;
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
    if (mapped) {
        memcpy(map->content.n_row, head.n_row, sizeof head.n_row);
        map->content.digest = head.digest;
    } else {
        RMAP_TRY(rmap_map_content_sort(&map->content, err));
        RMAP_TRY(rmap_map_content_check(&map->content, map->path, err));
    }
    rmap_map_derive_flux(map);
    RMAP_TRY(rmap_map_sum_up(map, err));
out:
    return st;
}

enum rmap_status rmap_map_state_take(struct rmap_map *map, uint8_t *blob, size_t nbytes,
                                     struct rmap_error *err)
{
    return take(map, blob, nbytes, false, err);
}

enum rmap_status rmap_map_state_join(struct rmap_map *map, int fd, struct rmap_error *err)
{
    void *address = NULL;
    size_t nbytes = 0;
    enum rmap_status st = rmap_shared_memory_map(fd, &address, &nbytes, err);
    if (st != RMAP_OK)
        return st;
    st = take(map, address, nbytes, true, err);
    if (map->content.mapped != address)
        (void)munmap(address, nbytes);
    return st;
}
