/* SPDX-License-Identifier: MIT */
#include "io/map_directory.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/history_file.h"
#include "io/map_format.h"
#include "io/map_writer.h"
#include "io/publish.h"

enum { DIGITS = 5 };

/* The number in "prefixNNNNNsuffix", or -1. */
static int numbered(const char *name, const char *prefix, const char *suffix)
{
    size_t n = strlen(prefix);
    int number = 0;
    if (strlen(name) != n + DIGITS + strlen(suffix) || strncmp(name, prefix, n) != 0 ||
        strcmp(name + n + DIGITS, suffix) != 0)
        return -1;
    for (int k = 0; k < DIGITS; k++) {
        char c = name[n + (size_t)k];
        if (c < '0' || c > '9')
            return -1;
        number = 10 * number + (c - '0');
    }
    return number;
}

static int shard_number(const char *name)
{
    return numbered(name, "shard-", "");
}

static int piece_number(const char *name)
{
    return numbered(name, "piece-", ".h5");
}

static int history_number(const char *name)
{
    return numbered(name, "piece-", RMAP_HISTORY_SUFFIX);
}

/* Calls visit for every entry but . and .. until it fails. */
static enum rmap_status visit_directory(const char *path,
                                        enum rmap_status (*visit)(void *context, const char *name,
                                                                  struct rmap_error *err),
                                        void *context, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    DIR *directory = opendir(path);
    if (!directory)
        return rmap_error_set(err, RMAP_SYSTEM, "%s: cannot list the directory: %s", path,
                              strerror(errno));
    struct dirent *entry;
    while (st == RMAP_OK && (errno = 0, entry = readdir(directory)))
        if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0)
            st = visit(context, entry->d_name, err);
    if (st == RMAP_OK && errno != 0)
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: reading the directory: %s", path,
                            strerror(errno));
    (void)closedir(directory);
    return st;
}

static enum rmap_status take_highest(void *context, const char *name, struct rmap_error *err)
{
    int *next = context;
    (void)err;
    if (piece_number(name) >= *next)
        *next = piece_number(name) + 1;
    return RMAP_OK;
}

enum rmap_status rmap_shard_next_piece(const char *shard_path, int *number_ret,
                                       struct rmap_error *err)
{
    *number_ret = 0;
    return visit_directory(shard_path, take_highest, number_ret, err);
}

struct piece_list {
    const char *map_path;
    int (*number_of)(const char *name); /* -1: not of this kind */
    int shard;
    struct rmap_piece_name *name;
    size_t n, cap;
};

static enum rmap_status list_piece(void *context, const char *name, struct rmap_error *err)
{
    struct piece_list *list = context;
    int number = list->number_of(name);
    if (number < 0)
        return RMAP_OK;
    void *block = list->name;
    enum rmap_status st = rmap_reserve(&block, &list->cap, list->n + 1, sizeof *list->name, err);
    list->name = block;
    if (st == RMAP_OK)
        list->name[list->n++] = (struct rmap_piece_name){list->shard, number};
    return st;
}

static enum rmap_status list_shard(void *context, const char *name, struct rmap_error *err)
{
    struct piece_list *list = context;
    list->shard = shard_number(name);
    if (list->shard < 0)
        return RMAP_OK;
    char *path = rmap_path_format("%s/%s", list->map_path, name);
    enum rmap_status st = path ? visit_directory(path, list_piece, list, err)
                               : rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    rmap_free(path);
    return st;
}

static int by_place(const void *a, const void *b)
{
    const struct rmap_piece_name *x = a, *y = b;
    if (x->shard != y->shard)
        return x->shard < y->shard ? -1 : 1;
    return (x->number > y->number) - (x->number < y->number);
}

static enum rmap_status list_files(const char *map_path, int (*number_of)(const char *name),
                                   struct rmap_piece_name **name_ret, size_t *n_ret,
                                   struct rmap_error *err)
{
    struct piece_list list = {.map_path = map_path, .number_of = number_of};
    enum rmap_status st = visit_directory(map_path, list_shard, &list, err);
    if (st != RMAP_OK) {
        rmap_free(list.name);
        return st;
    }
    if (list.n > 0)
        qsort(list.name, list.n, sizeof *list.name, by_place);
    *name_ret = list.name;
    *n_ret = list.n;
    return RMAP_OK;
}

enum rmap_status rmap_map_list_pieces(const char *map_path, struct rmap_piece_name **name_ret,
                                      size_t *n_ret, struct rmap_error *err)
{
    return list_files(map_path, piece_number, name_ret, n_ret, err);
}

enum rmap_status rmap_map_list_histories(const char *map_path, struct rmap_piece_name **name_ret,
                                         size_t *n_ret, struct rmap_error *err)
{
    return list_files(map_path, history_number, name_ret, n_ret, err);
}

/* ---- what unfinished writers left ---- */

static bool ends_with(const char *name, const char *suffix)
{
    size_t n = strlen(name), n_suffix = strlen(suffix);
    return n > n_suffix && strcmp(name + n - n_suffix, suffix) == 0;
}

static bool is_part(const char *name)
{
    return strncmp(name, ".piece-", 7) == 0 && ends_with(name, ".part");
}

static bool is_half_index(const char *name)
{
    return strncmp(name, ".map.h5.", 8) == 0 && ends_with(name, ".part");
}

static bool is_journal(const char *name)
{
    return strncmp(name, ".piece-", 7) == 0 && ends_with(name, ".journal");
}

bool rmap_leftover_is_held(const char *map_path, const struct rmap_leftover *leftover)
{
    char *part = rmap_path_format("%s/%s", map_path, leftover->name);
    char *journal = part ? rmap_journal_path(part) : NULL;
    int fd = journal ? open(journal, O_RDONLY | O_CLOEXEC) : -1;
    /* Shared: NFS gives no exclusive lock on a file that is open for reading, and two that look at
     * a time are not to take each other for the writer. */
    bool held = fd >= 0 && flock(fd, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    if (fd >= 0)
        (void)close(fd);
    rmap_free(journal);
    rmap_free(part);
    return held;
}

char *rmap_journal_path(const char *part_path)
{
    return rmap_path_format("%.*s.journal", (int)(strlen(part_path) - strlen(".part")), part_path);
}

struct leftover_list {
    const char *map_path, *shard_name;
    struct rmap_leftover *leftover;
    size_t n, cap;
};

/* One row per file; the two of a piece are joined later. */
static enum rmap_status list_leftover(void *context, const char *name, struct rmap_error *err)
{
    struct leftover_list *list = context;
    struct rmap_leftover row = {.shard = shard_number(list->shard_name),
                                .has_part = is_part(name),
                                .has_journal = is_journal(name)};
    if (!row.has_part && !row.has_journal)
        return RMAP_OK;
    int stem = (int)(strlen(name) - strlen(row.has_part ? ".part" : ".journal"));
    if ((size_t)snprintf(row.name, sizeof row.name, "%s/%.*s.part", list->shard_name, stem, name) >=
        sizeof row.name)
        return RMAP_OK; /* no name of ours is that long */
    void *block = list->leftover;
    enum rmap_status st =
        rmap_reserve(&block, &list->cap, list->n + 1, sizeof *list->leftover, err);
    list->leftover = block;
    if (st == RMAP_OK)
        list->leftover[list->n++] = row;
    return st;
}

static enum rmap_status list_shard_leftovers(void *context, const char *name,
                                             struct rmap_error *err)
{
    struct leftover_list *list = context;
    if (shard_number(name) < 0)
        return RMAP_OK;
    list->shard_name = name;
    char *path = rmap_path_format("%s/%s", list->map_path, name);
    enum rmap_status st = path ? visit_directory(path, list_leftover, list, err)
                               : rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    rmap_free(path);
    return st;
}

static int by_name(const void *a, const void *b)
{
    return strcmp(((const struct rmap_leftover *)a)->name, ((const struct rmap_leftover *)b)->name);
}

enum rmap_status rmap_map_list_leftovers(const char *map_path, struct rmap_leftover **leftover_ret,
                                         size_t *n_ret, struct rmap_error *err)
{
    struct leftover_list list = {.map_path = map_path};
    size_t kept = 0;
    enum rmap_status st = visit_directory(map_path, list_shard_leftovers, &list, err);
    if (st != RMAP_OK) {
        rmap_free(list.leftover);
        return st;
    }
    if (list.n > 0)
        qsort(list.leftover, list.n, sizeof *list.leftover, by_name);
    for (size_t i = 0; i < list.n; i++) {
        const struct rmap_leftover *row = &list.leftover[i];
        if (kept > 0 && strcmp(list.leftover[kept - 1].name, row->name) == 0) {
            list.leftover[kept - 1].has_part |= row->has_part;
            list.leftover[kept - 1].has_journal |= row->has_journal;
        } else {
            list.leftover[kept++] = *row;
        }
    }
    *leftover_ret = list.leftover;
    *n_ret = kept;
    return RMAP_OK;
}

/* RMAP_USAGE, naming its file, if a writer is at work just now. */
static enum rmap_status find_writer(const char *map_path, struct rmap_error *err)
{
    struct rmap_leftover *leftover = NULL;
    size_t n = 0;
    enum rmap_status st = rmap_map_list_leftovers(map_path, &leftover, &n, err);
    for (size_t i = 0; st == RMAP_OK && i < n; i++)
        if (rmap_leftover_is_held(map_path, &leftover[i]))
            st = rmap_error_set(err, RMAP_USAGE,
                                "%s is being traced by another raymap (it writes %s, which names "
                                "its host and process): stop that first",
                                map_path, leftover[i].name);
    rmap_free(leftover);
    return st;
}

/* One that was seen may be between two pieces when it is not seen any more: twice must be. */
enum rmap_status rmap_map_await_writers(const char *map_path, struct rmap_error *err)
{
    const struct timespec nap = {.tv_nsec = 100000000};
    const int naps_max = 50;
    enum rmap_status st = find_writer(map_path, err);
    int idle = st == RMAP_OK ? 2 : 0;
    for (int naps = 0; idle < 2 && naps < naps_max; naps++) {
        (void)nanosleep(&nap, NULL);
        st = find_writer(map_path, err);
        if (st != RMAP_OK && st != RMAP_USAGE)
            return st;
        idle = st == RMAP_OK ? idle + 1 : 0;
    }
    return st;
}

/* ---- making the directory, over an old map if told to ---- */

static bool is_temporary(const char *name)
{
    return is_part(name) || is_journal(name) || is_half_index(name);
}

struct clearing {
    const char *map_path;
    const char *shard; /* being visited, or NULL */
    bool remove;       /* false: look only */
};

static enum rmap_status foreign(const char *path, const char *name, struct rmap_error *err)
{
    return rmap_error_set(
        err, RMAP_USAGE,
        "%s holds '%s', which is no part of a ray map: nothing was removed; choose "
        "another name or remove it yourself",
        path, name);
}

static enum rmap_status remove_path(char *path, int (*how)(const char *), struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (!path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    if (how(path) != 0)
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: cannot be removed: %s", path, strerror(errno));
    rmap_free(path);
    return st;
}

static enum rmap_status clear_piece(void *context, const char *name, struct rmap_error *err)
{
    const struct clearing *clearing = context;
    if (piece_number(name) < 0 && history_number(name) < 0 && !is_temporary(name))
        return foreign(clearing->shard, name, err);
    if (!clearing->remove)
        return RMAP_OK;
    return remove_path(rmap_path_format("%s/%s", clearing->shard, name), unlink, err);
}

static enum rmap_status clear_shard(struct clearing *clearing, const char *name,
                                    struct rmap_error *err)
{
    char *path = rmap_path_format("%s/%s", clearing->map_path, name);
    if (!path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    clearing->shard = path;
    enum rmap_status st = visit_directory(path, clear_piece, clearing, err);
    if (st == RMAP_OK && clearing->remove)
        return remove_path(path, rmdir, err);
    rmap_free(path);
    return st;
}

static enum rmap_status clear_entry(void *context, const char *name, struct rmap_error *err)
{
    struct clearing *clearing = context;
    if (shard_number(name) >= 0)
        return clear_shard(clearing, name, err);
    if (strcmp(name, "map.h5") != 0 && strcmp(name, RMAP_INDEX_START) != 0 && !is_temporary(name))
        return foreign(clearing->map_path, name, err);
    if (!clearing->remove)
        return RMAP_OK;
    return remove_path(rmap_path_format("%s/%s", clearing->map_path, name), unlink, err);
}

/* Looks first, then removes: a directory with foreign files is left whole. */
static enum rmap_status clear_map(const char *path, struct rmap_error *err)
{
    struct clearing clearing = {.map_path = path};
    enum rmap_status st = visit_directory(path, clear_entry, &clearing, err);
    clearing.remove = true;
    return st == RMAP_OK ? visit_directory(path, clear_entry, &clearing, err) : st;
}

static enum rmap_status remove_half_index(void *context, const char *name, struct rmap_error *err)
{
    const char *map_path = context;
    return is_half_index(name) ? remove_path(rmap_path_format("%s/%s", map_path, name), unlink, err)
                               : RMAP_OK;
}

enum rmap_status rmap_map_remove_half_indexes(const char *map_path, struct rmap_error *err)
{
    char *path = rmap_strdup(map_path);
    enum rmap_status st = path ? visit_directory(path, remove_half_index, path, err)
                               : rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    rmap_free(path);
    return st;
}

enum rmap_status rmap_map_create(const char *path, bool force, struct rmap_error *err)
{
    struct stat info;
    if (mkdir(path, 0777) == 0)
        return rmap_sync_parent(path, err);
    int reason = errno;
    if (reason != EEXIST)
        return rmap_error_set(err, RMAP_SYSTEM, "%s: cannot make the directory: %s", path,
                              strerror(reason));
    if (!force)
        return rmap_error_set(err, RMAP_USAGE, "%s exists already: use another name, or --force",
                              path);
    if (stat(path, &info) != 0 || !S_ISDIR(info.st_mode))
        return rmap_error_set(err, RMAP_USAGE,
                              "%s is no directory, so no ray map: it is left as it is", path);
    enum rmap_status st = rmap_map_await_writers(path, err);
    return st == RMAP_OK ? clear_map(path, err) : st;
}
