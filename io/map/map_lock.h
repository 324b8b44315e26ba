/* SPDX-License-Identifier: MIT
 *
 * The right to write to a map, or to a folder of other results: one command at a time has it, from
 * before its first look at it until its end. It goes with the process, however it ends. Readers ask
 * nobody.
 */
#ifndef RMAP_MAP_LOCK_H
#define RMAP_MAP_LOCK_H

#include <stdbool.h>

#include "base/status.h"

/* In the map's directory while it is written to. Programs that know nothing of it take it for half
 * an index, which keeps nobody from anything. */
#define RMAP_MAP_LOCK_NAME ".map.h5.writer.part"

struct rmap_map_lock { /* zeroed: not held */
    int fd;
    char *path; /* NULL: not held */
};

/* Waits two seconds for a writer that is being killed. RMAP_USAGE names host, process and command
 * of one that stays; RMAP_SYSTEM. A directory that does not stand, or that this user cannot write
 * to, is not locked; one that is held already stays so. `command`: told to others. */
enum rmap_status rmap_map_lock_take(const char *map_path, const char *command,
                                    struct rmap_map_lock *self,
                                    struct rmap_error *err) RMAP_MUST_USE;
/* The same of a folder of other results, of which `raymap repair` knows nothing. */
enum rmap_status rmap_folder_lock_take(const char *folder, const char *command,
                                       struct rmap_map_lock *self,
                                       struct rmap_error *err) RMAP_MUST_USE;
/* Removes what a writer left where the file system keeps no locks, so that the next one can begin.
 * Only for one that has ended, which nobody but the user can know; a lock that is held is left. */
enum rmap_status rmap_map_lock_break(const char *map_path, struct rmap_error *err) RMAP_MUST_USE;
void rmap_map_lock_release(struct rmap_map_lock *self);

#endif
