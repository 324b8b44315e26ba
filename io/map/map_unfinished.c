/* SPDX-License-Identifier: MIT
 *
 * Files that killed writers left in a map, of which nothing counts.
 */
#include "io/map/map_unfinished.h"

#include <sys/stat.h>

#include "base/alloc.h"
#include "base/grouped.h"
#include "io/file/file_lock.h"
#include "io/file/publish.h"
#include "io/map/map_directory.h"

static enum rmap_status note(const char *map_path, const char *name, struct rmap_findings *findings,
                             struct rmap_error *err)
{
    struct rmap_finding finding;
    struct stat file;
    char *path = rmap_path_format("%s/%s", map_path, name);
    if (!path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    const bool is_left = lstat(path, &file) == 0 && !rmap_file_is_locked(path);
    rmap_free(path);
    if (!is_left)
        return RMAP_OK;
    rmap_finding_set(&finding, name, "", "%s that a killed command left; raymap repair removes it",
                     rmap_counted((uint64_t)file.st_size, "byte").text);
    return rmap_findings_add(findings, &finding, err);
}

enum rmap_status rmap_map_note_unfinished(const char *map_path, struct rmap_findings *findings,
                                          struct rmap_error *err)
{
    struct rmap_map_listing found = {0};
    enum rmap_status st = RMAP_OK;
    char *lock = rmap_path_format("%s/%s", map_path, RMAP_MAP_LOCK_NAME);
    if (!lock)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    if (rmap_file_is_locked(lock))
        goto out;
    RMAP_TRY(rmap_map_list(map_path, &found, err));
    for (size_t i = 0; i < found.n_half && st == RMAP_OK; i++)
        st = note(map_path, found.half[i].name, findings, err);
    for (size_t i = 0; i < found.n_leftover && st == RMAP_OK; i++)
        if (found.leftover[i].has_part && !found.leftover[i].has_journal)
            st = note(map_path, found.leftover[i].name, findings, err);
out:
    rmap_map_listing_fini(&found);
    rmap_free(lock);
    return st;
}
