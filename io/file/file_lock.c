/* SPDX-License-Identifier: MIT
 *
 * Locks that tell others that a file's writer lives.
 */
#include "io/file/file_lock.h"

#include <errno.h>
#include <fcntl.h>
#include <sys/file.h>
#include <time.h>
#include <unistd.h>

void rmap_file_lock(int fd)
{
    const struct timespec nap = {.tv_nsec = 1000000};
    const int tries = 20; /* somebody who looks holds it for a moment */
    for (int i = 0; i < tries && flock(fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK; i++)
        (void)nanosleep(&nap, NULL);
}

/* 0: nobody has it; EWOULDBLOCK: somebody does; else nobody can tell. */
static int look(const char *path)
{
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    /* Shared: NFS gives no exclusive lock on a file that is open for reading, and two that look at
     * a time are not to take each other for the writer. */
    const int why = fd >= 0 && flock(fd, LOCK_SH | LOCK_NB) == 0 ? 0 : errno;
    if (fd >= 0)
        (void)close(fd);
    return why;
}

bool rmap_file_is_locked(const char *path)
{
    return look(path) == EWOULDBLOCK;
}

bool rmap_file_is_left(const char *path)
{
    return look(path) == 0;
}
