/* SPDX-License-Identifier: MIT
 *
 * History indexes, shard-RRRRR/piece-KKKKK.history.h5: earlier versions wrote them beside pieces,
 * and nobody reads them any more.
 */
#include "io/map/history_file.h"

#include <sys/stat.h>

#include "base/alloc.h"
#include "io/file/publish.h"
#include "io/map/map_internal.h"

char *rmap_history_path(const char *map_path, const struct rmap_piece_name *piece)
{
    return rmap_path_format("%s/shard-%05d/piece-%05d" RMAP_HISTORY_SUFFIX, map_path, piece->shard,
                            piece->number);
}

enum rmap_status rmap_history_files_measure(const struct rmap_map *map,
                                            struct rmap_history_files *files,
                                            struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_piece_name *name = NULL;
    size_t n = 0;
    *files = (struct rmap_history_files){0};
    RMAP_TRY(rmap_map_list_histories(map->path, &name, &n, err));
    for (size_t i = 0; i < n; i++) {
        struct stat info;
        char *path = rmap_history_path(map->path, &name[i]);
        if (!path)
            RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a path"));
        if (stat(path, &info) == 0) {
            files->n++;
            files->nbytes += (uint64_t)info.st_size;
        }
        rmap_free(path);
    }
out:
    rmap_free(name);
    return st;
}
