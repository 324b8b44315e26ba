/* SPDX-License-Identifier: MIT
 *
 * The files of a map in its directory: NAME.raymap/map.h5, shard-RRRRR/piece-KKKKK.h5, and what
 * unfinished writers left: shard-RRRRR/.piece-KKKKK.h5.*.part with its .journal.
 */
#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/file/directory.h"
#include "io/file/file_lock.h"
#include "io/file/publish.h"
#include "io/map/map_directory.h"
#include "io/map/map_format.h"
#include "io/map/map_lock.h"
#include "io/map/map_writer.h"
#include "io/map/named_rays.h"
#include "io/map/piece_columns.h"

/* What unfinished writers left in a map's directory, and whether they live. */

static bool ends_with(const char *name, const char *suffix)
{
    size_t n = strlen(name), n_suffix = strlen(suffix);
    return n > n_suffix && strcmp(name + n - n_suffix, suffix) == 0;
}

/* What a name in a shard's directory is; or in the map's. */
static bool leftover_is_part(const char *name)
{
    return strncmp(name, ".piece-", 7) == 0 && ends_with(name, ".part");
}

static bool leftover_is_journal(const char *name)
{
    return strncmp(name, ".piece-", 7) == 0 && ends_with(name, ".journal");
}

/* An index, or named rays. */
static bool leftover_is_half_file(const char *name)
{
    return (strncmp(name, ".map.h5.", 8) == 0 || strncmp(name, ".selection-", 11) == 0) &&
           ends_with(name, ".part") && strcmp(name, RMAP_MAP_LOCK_NAME) != 0;
}

static bool is_named_rays(const char *name)
{
    char own[RMAP_RAYS_NAME_NBYTES];
    return rmap_named_rays_name(name, own);
}

static bool leftover_is_held(const char *map_path, const struct rmap_leftover *leftover)
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
        if (leftover->has_part || leftover_is_held(map_path, leftover))
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
        if (leftover_is_held(map_path, &found->leftover[i]))
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
    if (st == RMAP_OK && found->n_half > 0)
        st = rmap_map_remove_half_indexes(map_path, err);
    if (st != RMAP_OK)
        rmap_map_listing_fini(found);
    return st;
}

struct walk {
    const char *map_path, *shard_name;
    int shard;
    struct rmap_map_listing *listing;
};

static enum rmap_status add_name(struct rmap_piece_list *list, int shard, int number,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_RESERVE(list->name, list->cap, list->n + 1, err);
    if (st == RMAP_OK)
        list->name[list->n++] = (struct rmap_piece_name){shard, number};
    return st;
}

/* One row per file; the two of a piece are joined later. */
static enum rmap_status add_leftover(const struct walk *walk, const char *name,
                                     struct rmap_error *err)
{
    struct rmap_map_listing *listing = walk->listing;
    struct rmap_leftover row = {.shard = walk->shard,
                                .has_part = leftover_is_part(name),
                                .has_journal = leftover_is_journal(name)};
    if (!row.has_part && !row.has_journal)
        return RMAP_OK;
    int stem = (int)(strlen(name) - strlen(row.has_part ? ".part" : ".journal"));
    if ((size_t)snprintf(row.name, sizeof row.name, "%s/%.*s.part", walk->shard_name, stem, name) >=
        sizeof row.name)
        return RMAP_OK; /* no name of ours is that long */
    enum rmap_status st =
        RMAP_RESERVE(listing->leftover, listing->cap_leftover, listing->n_leftover + 1, err);
    if (st == RMAP_OK)
        listing->leftover[listing->n_leftover++] = row;
    return st;
}

static int columns_number(const char *name)
{
    return rmap_directory_number(name, "piece-", RMAP_COLUMNS_SUFFIX);
}

static enum rmap_status list_in_shard(void *context, int directory, const char *name,
                                      struct rmap_error *err)
{
    (void)directory;
    const struct walk *walk = context;
    int piece = rmap_directory_number(name, "piece-", ".h5");
    int history = rmap_directory_number(name, "piece-", RMAP_HISTORY_SUFFIX);
    if (piece >= 0)
        return add_name(&walk->listing->pieces, walk->shard, piece, err);
    if (history >= 0)
        return add_name(&walk->listing->histories, walk->shard, history, err);
    if (columns_number(name) >= 0)
        return add_name(&walk->listing->columns, walk->shard, columns_number(name), err);
    return add_leftover(walk, name, err);
}

static enum rmap_status add_half(struct rmap_map_listing *listing, const char *name,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_RESERVE(listing->half, listing->cap_half, listing->n_half + 1, err);
    if (st == RMAP_OK)
        (void)snprintf(listing->half[listing->n_half++].name, sizeof listing->half->name, "%s",
                       name);
    return st;
}

/* What stands there as a link is none of the map's: it is reported, and left to itself. */
static enum rmap_status list_in_map(void *context, int directory, const char *name,
                                    struct rmap_error *err)
{
    struct rmap_error why = {0};
    struct walk *walk = context;
    if (leftover_is_half_file(name))
        return add_half(walk->listing, name, err);
    walk->shard = rmap_directory_number(name, "shard-", "");
    walk->shard_name = name;
    if (walk->shard < 0)
        return RMAP_OK;
    char *path = rmap_path_format("%s/%s", walk->map_path, name);
    enum rmap_status st = path ? rmap_shard_visit(directory, path, list_in_shard, walk, &why)
                               : rmap_error_set(&why, RMAP_SYSTEM, "out of memory");
    rmap_free(path);
    if (st == RMAP_USAGE)
        walk->listing->link = why;
    else if (st != RMAP_OK && err)
        *err = why;
    return st == RMAP_USAGE ? RMAP_OK : st;
}

static int by_place(const void *a, const void *b)
{
    const struct rmap_piece_name *x = a, *y = b;
    if (x->shard != y->shard)
        return x->shard < y->shard ? -1 : 1;
    return (x->number > y->number) - (x->number < y->number);
}

static void sort_names(struct rmap_piece_list *list)
{
    if (list->n > 0)
        qsort(list->name, list->n, sizeof *list->name, by_place);
}

static int by_name(const void *a, const void *b)
{
    return strcmp(((const struct rmap_leftover *)a)->name, ((const struct rmap_leftover *)b)->name);
}

static void join_leftovers(struct rmap_map_listing *listing)
{
    struct rmap_leftover *list = listing->leftover;
    size_t kept = 0;
    if (listing->n_leftover > 0)
        qsort(list, listing->n_leftover, sizeof *list, by_name);
    for (size_t i = 0; i < listing->n_leftover; i++) {
        if (kept > 0 && strcmp(list[kept - 1].name, list[i].name) == 0) {
            list[kept - 1].has_part |= list[i].has_part;
            list[kept - 1].has_journal |= list[i].has_journal;
        } else {
            list[kept++] = list[i];
        }
    }
    listing->n_leftover = kept;
}

enum rmap_status rmap_map_list(const char *map_path, struct rmap_map_listing *listing,
                               struct rmap_error *err)
{
    struct walk walk = {.map_path = map_path, .listing = listing};
    *listing = (struct rmap_map_listing){0};
    enum rmap_status st = rmap_directory_visit(map_path, list_in_map, &walk, err);
    if (st != RMAP_OK)
        rmap_map_listing_fini(listing);
    sort_names(&listing->pieces);
    sort_names(&listing->histories);
    sort_names(&listing->columns);
    join_leftovers(listing);
    return st;
}

void rmap_map_listing_fini(struct rmap_map_listing *listing)
{
    rmap_free(listing->pieces.name);
    rmap_free(listing->histories.name);
    rmap_free(listing->columns.name);
    rmap_free(listing->leftover);
    rmap_free(listing->half);
    *listing = (struct rmap_map_listing){0};
}

/* ---- one kind alone ---- */

static enum rmap_status list_names(const char *map_path, bool histories,
                                   struct rmap_piece_name **name_ret, size_t *n_ret,
                                   struct rmap_error *err)
{
    struct rmap_map_listing listing;
    enum rmap_status st = rmap_map_list(map_path, &listing, err);
    struct rmap_piece_list *list = histories ? &listing.histories : &listing.pieces;
    if (st == RMAP_OK) {
        *name_ret = list->name;
        *n_ret = list->n;
        list->name = NULL;
    }
    rmap_map_listing_fini(&listing);
    return st;
}

enum rmap_status rmap_map_list_pieces(const char *map_path, struct rmap_piece_name **name_ret,
                                      size_t *n_ret, struct rmap_error *err)
{
    return list_names(map_path, false, name_ret, n_ret, err);
}

enum rmap_status rmap_map_list_histories(const char *map_path, struct rmap_piece_name **name_ret,
                                         size_t *n_ret, struct rmap_error *err)
{
    return list_names(map_path, true, name_ret, n_ret, err);
}

enum rmap_status rmap_map_list_leftovers(const char *map_path, struct rmap_leftover **leftover_ret,
                                         size_t *n_ret, struct rmap_error *err)
{
    struct rmap_map_listing listing;
    enum rmap_status st = rmap_map_list(map_path, &listing, err);
    if (st == RMAP_OK) {
        *leftover_ret = listing.leftover;
        *n_ret = listing.n_leftover;
        listing.leftover = NULL;
    }
    rmap_map_listing_fini(&listing);
    return st;
}

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
    return leftover_is_part(name) || leftover_is_journal(name) || leftover_is_half_file(name);
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
    if (piece_number(name) < 0 && history_number(name) < 0 && columns_number(name) < 0 &&
        !is_temporary(name))
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
        strcmp(name, RMAP_MAP_LOCK_NAME) != 0 && !is_named_rays(name) && !is_temporary(name))
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
    return leftover_is_half_file(name) ? remove_at(directory, map_path, name, 0, err) : RMAP_OK;
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
    if (!is_bare && reason == ENOENT)
        st = rmap_path_check_folder(path, err);
    if (st != RMAP_OK)
        return st;
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
