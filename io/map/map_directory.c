/* SPDX-License-Identifier: MIT */
#include "io/map/map_directory.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/file/directory.h"
#include "io/file/publish.h"
#include "io/map/history_file.h"
#include "io/map/map_format.h"
#include "io/map/map_lock.h"
#include "io/map/map_writer.h"

static int shard_number(const char *name)
{
    return rmap_directory_number(name, "shard-", "");
}

static int piece_number(const char *name)
{
    return rmap_directory_number(name, "piece-", ".h5");
}

static int history_number(const char *name)
{
    return rmap_directory_number(name, "piece-", RMAP_HISTORY_SUFFIX);
}

static enum rmap_status take_highest(void *context, int directory, const char *name,
                                     struct rmap_error *err)
{
    int *next = context;
    (void)directory, (void)err;
    if (piece_number(name) >= *next)
        *next = piece_number(name) + 1;
    return RMAP_OK;
}

enum rmap_status rmap_shard_next_piece(const char *shard_path, int *number_ret,
                                       struct rmap_error *err)
{
    *number_ret = 0;
    return rmap_shard_visit(AT_FDCWD, shard_path, take_highest, number_ret, err);
}

static enum rmap_status refuse_entry(void *context, int directory, const char *name,
                                     struct rmap_error *err)
{
    const char *shard_path = *(const char **)context;
    (void)directory;
    return rmap_error_set(err, RMAP_USAGE,
                          "%s holds '%s' of another map: move the folder into the directory of "
                          "that map, or write the shards elsewhere",
                          shard_path, name);
}

enum rmap_status rmap_shard_check_place(const char *directory, int shard, bool is_new,
                                        struct rmap_error *err)
{
    struct stat info;
    const char *path = NULL;
    char *own = rmap_path_format("%s/shard-%05d", directory, shard);
    enum rmap_status st = RMAP_OK;
    if (!own)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    path = own;
    if (stat(directory, &info) != 0 || !S_ISDIR(info.st_mode)) {
        st = rmap_error_set(err, RMAP_SYSTEM, "%s is no directory: shards cannot be written there",
                            directory);
        goto out;
    }
    if (mkdir(own, 0777) == 0) {
        (void)rmdir(own); /* it could be made: enough, as the run may yet be refused */
        goto out;
    }
    bool stands = errno == EEXIST;
    if (stands && is_new)
        RMAP_TRY(rmap_shard_visit(AT_FDCWD, own, refuse_entry, &path, err));
    if (!stands || access(own, W_OK | X_OK) != 0)
        st = rmap_error_set(err, RMAP_SYSTEM, "%s cannot be written (%s): give another --shard-dir",
                            own, strerror(errno));
out:
    rmap_free(own);
    return st;
}

/* ---- making the directory, over an old map if told to ---- */

static bool is_temporary(const char *name)
{
    return rmap_leftover_is_part(name) || rmap_leftover_is_journal(name) ||
           rmap_leftover_is_half_index(name);
}

struct clearing {
    const char *map_path;
    const char *shard; /* being visited, or NULL */
    bool remove;       /* false: look only */
    bool keeps_lock;   /* whoever clears has it */
};

static enum rmap_status foreign(const char *path, const char *name, struct rmap_error *err)
{
    return rmap_error_set(
        err, RMAP_USAGE,
        "%s holds '%s', which is no part of a ray map: nothing was removed; choose "
        "another name or remove it yourself",
        path, name);
}

/* flags: AT_REMOVEDIR for folders; path: for messages. */
static enum rmap_status remove_at(int directory, const char *path, const char *name, int flags,
                                  struct rmap_error *err)
{
    return unlinkat(directory, name, flags) == 0
               ? RMAP_OK
               : rmap_error_set(err, RMAP_SYSTEM, "%s/%s: cannot be removed: %s", path, name,
                                strerror(errno));
}

static enum rmap_status clear_piece(void *context, int directory, const char *name,
                                    struct rmap_error *err)
{
    const struct clearing *clearing = context;
    if (piece_number(name) < 0 && history_number(name) < 0 && !is_temporary(name))
        return foreign(clearing->shard, name, err);
    return clearing->remove ? remove_at(directory, clearing->shard, name, 0, err) : RMAP_OK;
}

static enum rmap_status clear_shard(struct clearing *clearing, int directory, const char *name,
                                    struct rmap_error *err)
{
    char *path = rmap_path_format("%s/%s", clearing->map_path, name);
    if (!path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    clearing->shard = path;
    enum rmap_status st = rmap_shard_visit(directory, path, clear_piece, clearing, err);
    if (st == RMAP_OK && clearing->remove)
        st = remove_at(directory, clearing->map_path, name, AT_REMOVEDIR, err);
    rmap_free(path);
    return st;
}

static enum rmap_status clear_entry(void *context, int directory, const char *name,
                                    struct rmap_error *err)
{
    struct clearing *clearing = context;
    if (strcmp(name, RMAP_MAP_LOCK_NAME) == 0 && clearing->keeps_lock)
        return RMAP_OK;
    if (shard_number(name) >= 0)
        return clear_shard(clearing, directory, name, err);
    if (strcmp(name, "map.h5") != 0 && strcmp(name, RMAP_INDEX_START) != 0 &&
        strcmp(name, RMAP_MAP_LOCK_NAME) != 0 && !is_temporary(name))
        return foreign(clearing->map_path, name, err);
    return clearing->remove ? remove_at(directory, clearing->map_path, name, 0, err) : RMAP_OK;
}

/* Looks first, then removes: a directory with foreign files is left whole. */
static enum rmap_status clear_map(const char *path, bool keeps_lock, struct rmap_error *err)
{
    struct clearing clearing = {.map_path = path, .keeps_lock = keeps_lock};
    enum rmap_status st = rmap_directory_visit(path, clear_entry, &clearing, err);
    clearing.remove = true;
    return st == RMAP_OK ? rmap_directory_visit(path, clear_entry, &clearing, err) : st;
}

static enum rmap_status remove_half_index(void *context, int directory, const char *name,
                                          struct rmap_error *err)
{
    const char *map_path = *(const char **)context;
    return rmap_leftover_is_half_index(name) ? remove_at(directory, map_path, name, 0, err)
                                             : RMAP_OK;
}

enum rmap_status rmap_map_remove_half_indexes(const char *map_path, struct rmap_error *err)
{
    return rmap_directory_visit(map_path, remove_half_index, &map_path, err);
}

static enum rmap_status see_entry(void *context, int directory, const char *name,
                                  struct rmap_error *err)
{
    bool *is_bare = context;
    (void)directory;
    (void)err;
    *is_bare = *is_bare && strcmp(name, RMAP_MAP_LOCK_NAME) == 0;
    return RMAP_OK;
}

static enum rmap_status exists_already(const char *path, struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_USAGE, "%s exists already: use another name, or --force", path);
}

/* Between its making and its locking another writer may have taken the directory for its own. */
enum rmap_status rmap_map_create(const char *path, bool force, const char *command,
                                 struct rmap_map_lock *lock, struct rmap_error *err)
{
    struct stat info;
    struct rmap_map_listing found;
    enum rmap_status st = RMAP_OK;
    bool is_bare = mkdir(path, 0777) == 0;
    int reason = errno;
    if (!is_bare && reason != EEXIST)
        return rmap_error_set(err, RMAP_SYSTEM, "%s: cannot make the directory: %s", path,
                              strerror(reason));
    if (!is_bare && !force)
        return exists_already(path, err);
    st = rmap_path_look(path, &info, err);
    if (st == RMAP_OK && !S_ISDIR(info.st_mode))
        st = rmap_error_set(err, RMAP_USAGE,
                            "%s is no directory, so no ray map: it is left as it is", path);
    if (st == RMAP_OK)
        st = rmap_map_lock_take(path, command, lock, err);
    if (st == RMAP_OK && is_bare)
        st = rmap_directory_visit(path, see_entry, &is_bare, err);
    if (st != RMAP_OK)
        return st;
    if (is_bare)
        return rmap_sync_parent(path, err);
    if (!force)
        return exists_already(path, err);
    st = rmap_map_await_writers(path, &found, err);
    rmap_map_listing_fini(&found);
    return st == RMAP_OK ? clear_map(path, lock != NULL, err) : st;
}

enum rmap_status rmap_map_remove(const char *path, struct rmap_error *err)
{
    enum rmap_status st = clear_map(path, false, err);
    if (st == RMAP_OK && rmdir(path) != 0)
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: cannot be removed: %s", path, strerror(errno));
    return st;
}
