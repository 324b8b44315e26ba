/* SPDX-License-Identifier: MIT
 *
 * The file of a piece that an open map lists.
 */
#include "io/map/piece_file.h"

#include <errno.h>
#include <fcntl.h>

#include "base/alloc.h"
#include "io/file/publish.h"
#include "io/map/map_format.h"

/* stat, or open without `info`. */
static int reach(const char *map_path, const char *name, struct stat *info)
{
    char *path = rmap_path_format("%s/%s", map_path, name);
    if (!path) {
        errno = ENOMEM;
        return -1;
    }
    int got = info ? stat(path, info) : open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    int reason = errno;
    rmap_free(path);
    errno = reason;
    return got;
}

static int reach_piece(const char *map_path, const struct rmap_piece_info *piece, struct stat *info)
{
    int got = reach(map_path, piece->name, info);
    if (got >= 0 || errno != ENOENT || !piece->is_open)
        return got;
    struct rmap_piece_info published = *piece;
    rmap_piece_name_set(&published);
    return reach(map_path, published.name, info);
}

int rmap_piece_file_open(const char *map_path, const struct rmap_piece_info *piece)
{
    return reach_piece(map_path, piece, NULL);
}

int rmap_piece_file_stat(const char *map_path, const struct rmap_piece_info *piece,
                         struct stat *info)
{
    return reach_piece(map_path, piece, info);
}
