/* SPDX-License-Identifier: MIT
 *
 * Locks that tell others that a file's writer lives. They go with the process, however it ends, and
 * keep nobody from reading. Where the file system keeps no locks, nobody is told.
 */
#ifndef RMAP_FILE_LOCK_H
#define RMAP_FILE_LOCK_H

#include <stdbool.h>

/* Until the file is closed. Another writer's lock, or HDF5's own, does as well. */
void rmap_file_lock(int fd);

/* Whether somebody writes to the file; false also where it cannot be opened. */
bool rmap_file_is_locked(const char *path);

/* Whether nobody does, as the lock itself shows; false where it cannot be asked for. */
bool rmap_file_is_left(const char *path);

#endif
