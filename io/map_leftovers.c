/* SPDX-License-Identifier: MIT
 *
 * What unfinished writers left in a map's directory, and whether they live.
 */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/directory.h"
#include "io/file_lock.h"
#include "io/map_directory.h"
#include "io/publish.h"

static bool ends_with(const char *name, const char *suffix)
{
    size_t n = strlen(name), n_suffix = strlen(suffix);
    return n > n_suffix && strcmp(name + n - n_suffix, suffix) == 0;
}

bool rmap_leftover_is_part(const char *name)
{
    return strncmp(name, ".piece-", 7) == 0 && ends_with(name, ".part");
}

bool rmap_leftover_is_journal(const char *name)
{
    return strncmp(name, ".piece-", 7) == 0 && ends_with(name, ".journal");
}

bool rmap_leftover_is_held(const char *map_path, const struct rmap_leftover *leftover)
{
    char *part = rmap_path_format("%s/%s", map_path, leftover->name);
    char *journal = part ? rmap_journal_path(part) : NULL;
    bool held = journal && (rmap_file_is_locked(journal) || rmap_file_is_locked(part));
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
    struct rmap_leftover row = {.shard = rmap_directory_number(list->shard_name, "shard-", ""),
                                .has_part = rmap_leftover_is_part(name),
                                .has_journal = rmap_leftover_is_journal(name)};
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
    if (rmap_directory_number(name, "shard-", "") < 0)
        return RMAP_OK;
    list->shard_name = name;
    char *path = rmap_path_format("%s/%s", list->map_path, name);
    enum rmap_status st = path ? rmap_directory_visit(path, list_leftover, list, err)
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
    enum rmap_status st = rmap_directory_visit(map_path, list_shard_leftovers, &list, err);
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

enum rmap_status rmap_map_check_indexless(const char *map_path, struct rmap_error *err)
{
    struct rmap_piece_name *name = NULL;
    struct rmap_leftover *leftover = NULL;
    size_t n = 0, n_leftover = 0;
    enum rmap_status st = rmap_map_list_pieces(map_path, &name, &n, err);
    if (st == RMAP_OK)
        st = rmap_map_list_leftovers(map_path, &leftover, &n_leftover, err);
    for (size_t i = 0; i < n_leftover; i++)
        n += leftover[i].has_journal;
    rmap_free(name);
    rmap_free(leftover);
    if (st == RMAP_OK && n > 0)
        st = rmap_error_set(err, RMAP_FORMAT,
                            "%s has pieces but no map.h5, its index: raymap repair makes it again",
                            map_path);
    return st;
}

enum rmap_status rmap_map_remove_spent_journals(const char *map_path, struct rmap_error *err)
{
    struct rmap_leftover *leftover = NULL;
    size_t n = 0;
    enum rmap_status st = rmap_map_list_leftovers(map_path, &leftover, &n, err);
    for (size_t i = 0; st == RMAP_OK && i < n; i++) {
        if (leftover[i].has_part || rmap_leftover_is_held(map_path, &leftover[i]))
            continue;
        char *part = rmap_path_format("%s/%s", map_path, leftover[i].name);
        char *journal = part ? rmap_journal_path(part) : NULL;
        if (!journal)
            st = rmap_error_set(err, RMAP_SYSTEM, "out of memory");
        else
            (void)unlink(journal);
        rmap_free(journal);
        rmap_free(part);
    }
    rmap_free(leftover);
    return st;
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

bool rmap_map_is_live(const char *map_path)
{
    return find_writer(map_path, NULL) == RMAP_USAGE;
}

/* One that was seen may be between two pieces when it is not seen any more: twice must be. */
enum rmap_status rmap_map_await_writers(const char *map_path, struct rmap_error *err)
{
    const struct timespec nap = {.tv_nsec = 100000000};
    const int naps_max = 50;
    struct stat info;
    if (stat(map_path, &info) != 0 || !S_ISDIR(info.st_mode))
        return RMAP_OK;
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
