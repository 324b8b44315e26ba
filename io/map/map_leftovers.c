/* SPDX-License-Identifier: MIT
 *
 * What unfinished writers left in a map's directory, and whether they live.
 */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/file/directory.h"
#include "io/file/file_lock.h"
#include "io/file/publish.h"
#include "io/map/map_directory.h"
#include "io/map/map_lock.h"

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

bool rmap_leftover_is_half_index(const char *name)
{
    return strncmp(name, ".map.h5.", 8) == 0 && ends_with(name, ".part") &&
           strcmp(name, RMAP_MAP_LOCK_NAME) != 0;
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

enum rmap_status rmap_map_check_indexless(const char *map_path, struct rmap_error *err)
{
    struct rmap_map_listing found;
    enum rmap_status st = rmap_map_list(map_path, &found, err);
    size_t n = found.pieces.n;
    for (size_t i = 0; i < found.n_leftover; i++)
        n += found.leftover[i].has_journal;
    rmap_map_listing_fini(&found);
    if (st == RMAP_OK && n > 0)
        st = rmap_error_set(err, RMAP_FORMAT,
                            "%s has pieces but no map.h5, its index: raymap repair makes it again",
                            map_path);
    return st;
}

enum rmap_status rmap_map_remove_spent_journals(const char *map_path,
                                                const struct rmap_map_listing *found,
                                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; st == RMAP_OK && i < found->n_leftover; i++) {
        const struct rmap_leftover *leftover = &found->leftover[i];
        if (leftover->has_part || rmap_leftover_is_held(map_path, leftover))
            continue;
        char *part = rmap_path_format("%s/%s", map_path, leftover->name);
        char *journal = part ? rmap_journal_path(part) : NULL;
        if (!journal)
            st = rmap_error_set(err, RMAP_SYSTEM, "out of memory");
        else
            (void)!rmap_shard_unlink(journal); /* harmless where it cannot be removed */
        rmap_free(journal);
        rmap_free(part);
    }
    return st;
}

/* RMAP_USAGE, naming its file, if a writer is at work just now. */
static enum rmap_status find_writer(const char *map_path, struct rmap_map_listing *found,
                                    struct rmap_error *err)
{
    enum rmap_status st = rmap_map_list(map_path, found, err);
    for (size_t i = 0; st == RMAP_OK && i < found->n_leftover; i++)
        if (rmap_leftover_is_held(map_path, &found->leftover[i]))
            st = rmap_error_set(err, RMAP_USAGE,
                                "%s is being traced by another raymap (it writes %s, which names "
                                "its host and process): stop that first",
                                map_path, found->leftover[i].name);
    if (st != RMAP_OK)
        rmap_map_listing_fini(found);
    return st;
}

bool rmap_map_is_live(const char *map_path)
{
    struct rmap_map_listing found;
    bool live = find_writer(map_path, &found, NULL) == RMAP_USAGE;
    rmap_map_listing_fini(&found);
    return live;
}

/* One that was seen may be between two pieces when it is not seen any more: twice must be. */
enum rmap_status rmap_map_await_writers(const char *map_path, struct rmap_map_listing *found,
                                        struct rmap_error *err)
{
    const struct timespec nap = {.tv_nsec = 100000000};
    const int naps_max = 50;
    enum rmap_status st = find_writer(map_path, found, err);
    int idle = st == RMAP_OK ? 2 : 0;
    for (int naps = 0; idle < 2 && naps < naps_max; naps++) {
        if (st != RMAP_OK && st != RMAP_USAGE)
            return st;
        (void)nanosleep(&nap, NULL);
        rmap_map_listing_fini(found);
        st = find_writer(map_path, found, err);
        idle = st == RMAP_OK ? idle + 1 : 0;
    }
    if (st == RMAP_OK && found->link.text[0])
        st = rmap_error_set(err, RMAP_USAGE, "%s", found->link.text);
    if (st == RMAP_OK && found->has_half_index)
        st = rmap_map_remove_half_indexes(map_path, err);
    if (st != RMAP_OK)
        rmap_map_listing_fini(found);
    return st;
}
