/* SPDX-License-Identifier: MIT
 *
 * What a repaired map has no use for.
 */
#include "io/recovery/repair.h"

#include <errno.h>
#include <string.h>
#include <sys/stat.h>

#include "base/alloc.h"
#include "io/file/directory.h"
#include "io/file/publish.h"
#include "io/file/seal.h"
#include "io/map/history_file.h"
#include "io/map/journal.h"
#include "io/map/map_directory.h"
#include "io/map/map_history.h"
#include "io/map/map_internal.h"
#include "io/map/map_rays.h"

struct removal {
    const struct rmap_verification *self;
    const struct rmap_map_content *now; /* what the index lists */
    struct rmap_ray_set rays;           /* that it holds */
    struct rmap_findings *done;
};

static bool lists(const struct rmap_map_content *content, const char *name)
{
    for (size_t i = 0; i < content->n_piece; i++)
        if (strcmp(content->piece[i].name, name) == 0)
            return true;
    return false;
}

static bool was_replaced(const struct rmap_verification *self, const char *name)
{
    for (size_t i = 0; i < self->content->n_piece; i++)
        if (strcmp(self->content->piece[i].name, name) == 0)
            return !(self->piece_flag[i] & RMAP_PIECE_GONE) && rmap_repair_replaces(self, i);
    return false;
}

/* *why_ret NULL: the file stays, as it does where anything of it cannot be told just now. */
static enum rmap_status why_remove(const struct removal *removal,
                                   const struct rmap_piece_name *name, const char *file,
                                   const char *path, const char **why_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_map *map = removal->self->map;
    struct rmap_map_content content = {0};
    struct rmap_piece_origin origin = {0};
    struct rmap_ray_set own = {0}, rest = {0};
    struct rmap_error why = {0};
    struct stat status;
    *why_ret = NULL;
    RMAP_TRY(rmap_path_look(path, &status, &why));
    if (S_ISDIR(status.st_mode))
        goto out; /* whoever put it there knows what is in it */
    if (was_replaced(removal->self, file)) {
        *why_ret = "removed: what was good of it stands in another piece";
        goto out;
    }
    st = rmap_seal_check(path, &why);
    if (st == RMAP_FORMAT)
        *why_ret = "removed: it was damaged";
    RMAP_TRY(st);
    RMAP_TRY(
        rmap_piece_read(removal->self->path, name->shard, name->number, &content, &origin, &why));
    if (origin.seed != map->summary.seed || strcmp(origin.scene_digest, map->scene_digest) != 0)
        goto out;
    RMAP_TRY(rmap_rays_held(&content, &own, &why));
    RMAP_TRY(rmap_ray_set_minus(&own, &removal->rays, &rest, &why));
    if (rest.n == 0)
        *why_ret = "removed: other pieces hold its rays";
out:
    rmap_ray_set_fini(&own);
    rmap_ray_set_fini(&rest);
    rmap_map_content_fini(&content);
    return st == RMAP_SYSTEM ? rmap_error_set(err, st, "%s", why.text) : RMAP_OK;
}

static enum rmap_status remove_piece(const struct removal *removal,
                                     const struct rmap_piece_name *name, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_piece_info info = {.shard = name->shard, .number = name->number};
    rmap_piece_name_set(&info);
    if (lists(removal->now, info.name))
        return RMAP_OK;
    char *path = rmap_path_format("%s/%s", removal->self->path, info.name);
    if (!path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    const char *why = NULL;
    st = why_remove(removal, name, info.name, path, &why, err);
    if (why && rmap_shard_unlink(path) != 0)
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: cannot be removed: %s", path, strerror(errno));
    if (why && st == RMAP_OK)
        st = rmap_findings_note(removal->done, info.name, why, err);
    rmap_free(path);
    return st;
}

/* A history index that is damaged, or whose piece is gone: it can be made again. */
static enum rmap_status remove_history(const struct removal *removal, const struct rmap_map *map,
                                       const struct rmap_piece_name *name, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_map_content *now = removal->now;
    struct rmap_piece_info info = {.shard = name->shard, .number = name->number};
    struct rmap_error why = {0};
    size_t i = 0;
    while (i < now->n_piece &&
           (now->piece[i].shard != name->shard || now->piece[i].number != name->number))
        i++;
    bool orphaned = i == now->n_piece;
    if (!orphaned)
        st = rmap_map_history_check(map, i, &why);
    if (st == RMAP_SYSTEM)
        return rmap_error_set(err, st, "%s", why.text);
    if (!orphaned && st != RMAP_FORMAT)
        return RMAP_OK;
    st = RMAP_OK;
    char *path = rmap_history_path(removal->self->path, &info);
    if (!path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    if (rmap_shard_unlink(path) != 0)
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: cannot be removed: %s", path, strerror(errno));
    else
        st = rmap_findings_note(removal->done, path + strlen(removal->self->path) + 1,
                                orphaned ? "removed: its piece is gone"
                                         : "removed: it was damaged; raymap index makes it again",
                                err);
    rmap_free(path);
    return st;
}

static enum rmap_status remove_histories(const struct removal *removal, const struct rmap_map *map,
                                         struct rmap_error *err)
{
    struct rmap_piece_name *name = NULL;
    size_t n = 0;
    enum rmap_status st = rmap_map_list_histories(removal->self->path, &name, &n, err);
    for (size_t i = 0; i < n && st == RMAP_OK; i++)
        st = remove_history(removal, map, &name[i], err);
    rmap_free(name);
    return st;
}

enum rmap_status rmap_repair_remove(const struct rmap_verification *self,
                                    struct rmap_findings *done, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_piece_name *name = NULL;
    struct rmap_map *map = NULL;
    size_t n = 0;
    struct removal removal = {.self = self, .done = done};
    RMAP_TRY(rmap_map_list_pieces(self->path, &name, &n, err));
    RMAP_TRY(rmap_map_open_listed(self->path, &map, err));
    removal.now = &map->content;
    RMAP_TRY(rmap_rays_held(removal.now, &removal.rays, err));
    for (size_t i = 0; i < n; i++)
        RMAP_TRY(remove_piece(&removal, &name[i], err));
    RMAP_TRY(remove_histories(&removal, map, err));
out:
    rmap_ray_set_fini(&removal.rays);
    rmap_map_close(map);
    rmap_free(name);
    return st;
}

enum rmap_status rmap_repair_remove_leftover(const char *path, const char *name,
                                             struct rmap_findings *done, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_journal journal = {0};
    struct stat info;
    char *part = rmap_path_format("%s/%s", path, name);
    char *journal_path = part ? rmap_journal_path(part) : NULL;
    if (!journal_path) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory");
        goto out;
    }
    enum rmap_status read = rmap_journal_read(journal_path, &journal, NULL);
    RMAP_TRY(rmap_path_look(part, &info, err));
    const bool odd = info.st_mode != 0 && !S_ISREG(info.st_mode);
    if (read == RMAP_SYSTEM || journal.other_version ||
        (read == RMAP_OK && journal.n_portion > 0 && !odd))
        goto out; /* nobody knows, or another raymap does, or of another scene: not ours */
    if ((rmap_shard_unlink(journal_path) != 0 && errno != ENOENT) ||
        (rmap_shard_unlink(part) != 0 && errno != ENOENT)) {
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: cannot be removed: %s", part, strerror(errno));
        goto out;
    }
    st = rmap_findings_note(
        done, name, odd ? "removed: it is not a regular file" : "removed: its journal was damaged",
        err);
out:
    rmap_journal_fini(&journal);
    rmap_free(journal_path);
    rmap_free(part);
    return st;
}
